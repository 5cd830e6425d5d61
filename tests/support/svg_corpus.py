"""SVG drawings of the patterns of `fold_corpus`, in the many ways in which programs write the same lines."""

from collections.abc import Callable
from pathlib import Path

from tests.support.fold_corpus import Data

COLOURS = {"M": "#ff0000", "V": "#0000ff", "B": "#000000", "C": "#00ff00", "F": "#ffff00", "U": "#ff00ff"}
DOCTYPE = (
    '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">\n'
)
ADOBE = """<!-- Generator: Adobe Illustrator 16.0.0, SVG Export Plug-In . SVG Version: 6.00 Build 0)  -->
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
	<!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">
	<!ENTITY ns_svg "http://www.w3.org/2000/svg">
]>
"""
HEAD = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
DEPTH = 14  # groups in one another, as the deepest of the files that people draw


class Line:
    """An edge of a pattern, in mm, y down."""

    def __init__(self, data: Data, edge: int) -> None:
        a, b = data["edges_vertices"][edge]
        (self.x1, y1, *_), (self.x2, y2, *_) = (data["vertices_coords"][v] for v in (a, b))
        self.y1, self.y2 = 0.0 - y1, 0.0 - y2
        self.kind = data["edges_assignment"][edge]
        angle = (data.get("edges_foldAngle") or [None] * (edge + 1))[edge]
        self.opacity = 1.0 if angle is None else abs(angle) / 180.0

    @property
    def ends(self) -> str:
        return f'x1="{self.x1!r}" y1="{self.y1!r}" x2="{self.x2!r}" y2="{self.y2!r}"'


def by_attributes(lines: list[Line]) -> str:
    return "".join(
        f'<line id="e{k}" {line.ends} stroke="{COLOURS[line.kind]}" stroke-opacity="{line.opacity!r}"/>\n'
        for k, line in enumerate(lines)
    )


def by_styles(lines: list[Line]) -> str:
    return "".join(
        f'<path d="M {line.x1!r},{line.y1!r} L {line.x2!r} {line.y2!r}" '
        f'style="fill:none;stroke:{COLOURS[line.kind]};opacity:{line.opacity!r}"/>\n'
        for line in lines
    )


def by_classes(lines: list[Line]) -> str:
    rules = "".join(f".k{kind} , #none {{ stroke : {colour} }}\n" for kind, colour in COLOURS.items())
    return f'<style type="text/css"><![CDATA[\npath{{fill:none}} /* }} */\n{rules}]]></style>\n' + "".join(
        f'<polyline class="edge k{line.kind}" points="{line.x1!r},{line.y1!r} {line.x2!r},{line.y2!r}" '
        f'opacity="{line.opacity!r}" fill="none"/>\n'
        for line in lines
    )


def by_groups(lines: list[Line]) -> str:
    """Groups of a kind and an opacity, 14 deep; their transforms and opacities come to the whole."""
    found = ""
    for kind, opacity in sorted({(line.kind, line.opacity) for line in lines}):
        inside = "".join(
            f'<line x1="{(line.x1 - 1) / 2!r}" y1="{(line.y1 - 1) / 2!r}" x2="{(line.x2 - 1) / 2!r}" '
            f'y2="{(line.y2 - 1) / 2!r}"/>'
            for line in lines
            if (line.kind, line.opacity) == (kind, opacity)
        )
        opening = f'<g stroke="{COLOURS[kind]}" opacity="{opacity!r}" transform="translate(1 1) scale(2)">'
        found += opening + "<g>" * (DEPTH - 1) + inside + "</g>" * DEPTH + "\n"
    return found


def by_use(lines: list[Line]) -> str:
    """A unit line for each, placed by a matrix; symbols and definitions are not drawn where they stand."""
    placed = "".join(
        f'<use xlink:href="#unit" stroke="{COLOURS[line.kind]}" stroke-opacity="{line.opacity!r}" '
        f'transform="matrix({line.x2 - line.x1!r},{line.y2 - line.y1!r},0,1,{line.x1!r},{line.y1!r})"/>\n'
        for line in lines
    )
    return f'<defs><line id="unit" x1="0" y1="0" x2="1" y2="0"/></defs>\n{placed}'


def by_paths(lines: list[Line]) -> str:
    """One path for all lines of a kind and an opacity, with relative and level commands."""
    found = ""
    for kind, opacity in sorted({(line.kind, line.opacity) for line in lines}):
        d = ""
        for line in lines:
            if (line.kind, line.opacity) == (kind, opacity):
                d += f"M{line.x1!r} {line.y1!r}"
                d += f"H{line.x2!r}" if line.y1 == line.y2 else f"L{line.x2!r},{line.y2!r}"
        found += f'<path d="{d}" stroke="{COLOURS[kind]}" stroke-opacity="{opacity!r}" fill="none"/>\n'
    return found


WAYS: dict[str, Callable[[list[Line]], str]] = {
    "attributes": by_attributes,
    "styles": by_styles,
    "classes": by_classes,
    "groups": by_groups,
    "use": by_use,
    "paths": by_paths,
}


def lines_of(data: Data) -> list[Line]:
    return [Line(data, edge) for edge in range(len(data["edges_vertices"]))]


def svg(data: Data, way: str = "attributes", *, head: str = "", size: str | None = None) -> str:
    """A pattern in mm as SVG; `size`: attributes of the root in place of those that say mm."""
    lines = lines_of(data)
    xs, ys = (
        [x for line in lines for x in (line.x1, line.x2)],
        [y for line in lines for y in (line.y1, line.y2)],
    )
    x, y, width, height = min(xs), min(ys), max(xs) - min(xs), max(ys) - min(ys)
    given = f'width="{width!r}mm" height="{height!r}mm" viewBox="{x!r} {y!r} {width!r} {height!r}"'
    return f'<?xml version="1.0"?>\n{head}<svg {HEAD} {given if size is None else size}>\n{WAYS[way](lines)}</svg>\n'


def write(
    path: Path, data: Data, way: str = "attributes", *, head: str = "", size: str | None = None
) -> Path:
    path.write_text(svg(data, way, head=head, size=size), encoding="utf-8")
    return path
