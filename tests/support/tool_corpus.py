"""Crease patterns as particular tools write them, one of each habit: FOLD of other exporters, SVG of drawing programs.

In: nothing. Out: by name, a file's name and bytes.
"""

import json
import math
from collections.abc import Callable
from typing import Any

from tests.support import fold_corpus, large_corpus

Data = dict[str, Any]
File = tuple[str, bytes]


def _fold(data: Data, name: str = "sheet.fold", mark: bytes = b"") -> File:
    return name, mark + json.dumps(data).encode()


def _without(data: Data, *keys: str) -> Data:
    return {key: value for key, value in data.items() if key not in keys}


def unassigned() -> File:
    """Every edge, the rim too, is U, as from a planar graph."""
    data = fold_corpus.miura(4, 3)
    return _fold(data | {"edges_assignment": ["U"] * len(data["edges_vertices"])})


def unassigned_inside() -> File:
    data = fold_corpus.miura(4, 3)
    return _fold(
        data | {"edges_assignment": ["B" if kind == "B" else "U" for kind in data["edges_assignment"]]}
    )


def faces_alone() -> File:
    """A mesh: vertices and faces, no edges, no unit."""
    data = fold_corpus.miura(4, 3, faces=True, unit=None)
    return _fold(_without(data, "edges_vertices", "edges_assignment"))


def folded_mesh() -> File:
    """The same in space, folded, without angles."""
    data = large_corpus.in_space(large_corpus.miura(4, 3))
    return _fold(_without(data, "edges_vertices", "edges_assignment", "edges_foldAngle"))


def folded_frame() -> File:
    """Folded, with assignments and no angles: these are read off the sheet in space."""
    data = large_corpus.in_space(large_corpus.waterbomb(2, 2))
    classes = {"frame_classes": ["foldedForm"], "frame_attributes": ["3D"]}
    return _fold(_without(data, "edges_foldAngle", "frame_unit") | classes)


def frames_only() -> File:
    """Metadata at the top, the pattern in a frame of its own, its folded form in another."""
    data = large_corpus.miura(4, 3)
    inner = _without(data, "file_spec", "file_creator")
    folded = large_corpus.in_space(data)["vertices_coords"]
    frames = [
        inner | {"frame_classes": ["creasePattern"], "frame_title": "flat"},
        {
            "frame_classes": ["foldedForm"],
            "frame_parent": 1,
            "frame_inherit": True,
            "vertices_coords": folded,
        },
    ]
    return _fold(
        {"file_spec": 1.1, "file_creator": "a tool", "file_classes": ["singleModel"], "file_frames": frames}
    )


def own_corners() -> File:
    """Each facet has vertices and edges of its own, as of a mesh for printing: creases are drawn twice."""
    data = fold_corpus.miura(4, 3, faces=True)
    kinds = {frozenset(e): k for e, k in zip(data["edges_vertices"], data["edges_assignment"], strict=True)}
    points: list[Any] = []
    edges: list[list[int]] = []
    letters: list[str] = []
    rings = []
    for ring in data["faces_vertices"]:
        first = len(points)
        points += [data["vertices_coords"][v] for v in ring]
        rings.append(list(range(first, len(points))))
        for k, a in enumerate(ring):
            edges.append([first + k, first + (k + 1) % len(ring)])
            letters.append(kinds[frozenset((a, ring[(k + 1) % len(ring)]))])
    changed = {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": letters}
    return _fold(data | changed | {"faces_vertices": rings})


def square_twist() -> File:
    """A twist of a square in a square of pleats: facets of very many sizes."""
    turned, half, far = math.radians(20.0), 15.0, 60.0
    inner = [
        (half * math.cos(turned + k * math.pi / 2), half * math.sin(turned + k * math.pi / 2))
        for k in range(4)
    ]
    lines: list[tuple[tuple[float, float], tuple[float, float], str]] = []
    for k, (x, y) in enumerate(inner):
        lines.append(((x, y), inner[(k + 1) % 4], "V"))
        way = [(1, 0), (0, 1), (-1, 0), (0, -1)][k]
        other = [(0, 1), (-1, 0), (0, -1), (1, 0)][k]
        for (dx, dy), kind in ((way, "M"), (other, "V")):
            end = (far * dx if dx else x, far * dy if dy else y)
            lines.append(((x, y), end, kind))
    rim = [(-far, -far), (far, -far), (far, far), (-far, far)]
    ends = sorted(
        {b for _, b, _ in lines if max(map(abs, b)) == far} | set(rim), key=lambda p: math.atan2(p[1], p[0])
    )
    lines += [(a, b, "B") for a, b in zip(ends, [*ends[1:], ends[0]], strict=True)]
    places: dict[tuple[float, float], int] = {}
    edges = [[places.setdefault(a, len(places)), places.setdefault(b, len(places))] for a, b, _ in lines]
    data = {"file_spec": 1.1, "vertices_coords": [list(p) for p in places], "edges_vertices": edges}
    return _fold(data | {"edges_assignment": [kind for *_, kind in lines]})


def byte_order_mark() -> File:
    return _fold(fold_corpus.miura(4, 3, unit="unit"), mark=b"\xef\xbb\xbf")


def flat_folded() -> File:
    """All angles at 180 degrees: the state that a drawing of the folded form has."""
    data = fold_corpus.miura(4, 3)
    angles = [{"M": -180, "V": 180}.get(kind, 0) for kind in data["edges_assignment"]]
    return _fold(data | {"edges_foldAngle": angles})


def texts_for_numbers() -> File:
    """A spec that is a text, kinds in small letters, empty lists for what the tool has not."""
    data = fold_corpus.yoshimura(3, 3)
    kinds = [kind.lower() for kind in data["edges_assignment"]]
    empty: Data = {"faces_vertices": [], "edges_foldAngle": [], "faceOrders": [], "vertices_edges": []}
    return _fold(data | {"file_spec": "1.1", "edges_assignment": kinds} | empty)


def joined_edges() -> File:
    """Of FOLD 1.2: J for edges of one facet that are drawn, C for cuts, null for nothing known."""
    data = fold_corpus.miura(4, 3)
    kinds = list(data["edges_assignment"])
    inside = [k for k, kind in enumerate(kinds) if kind != "B"]
    kinds[inside[0]], kinds[inside[-1]] = "J", "U"
    return _fold(data | {"file_spec": 1.2, "edges_assignment": kinds})


def three_at_an_edge() -> File:
    """A third facet stands on a crease: no sheet."""
    data = fold_corpus.miura(2, 1, faces=True)
    points = [[*point[:2], 0.0] for point in data["vertices_coords"]]
    a, b = next(e for e, k in zip(data["edges_vertices"], data["edges_assignment"], strict=True) if k in "MV")
    points.append([*points[a][:2], 20.0])
    rings = [*data["faces_vertices"], [a, b, len(points) - 1]]
    edges = [*data["edges_vertices"], [a, len(points) - 1], [b, len(points) - 1]]
    return _fold(
        data
        | {"vertices_coords": points, "faces_vertices": rings, "edges_vertices": edges}
        | {"edges_assignment": [*data["edges_assignment"], "B", "B"]}
    )


def nothing_folds() -> File:
    data = fold_corpus.miura(3, 3)
    return _fold(
        data | {"edges_assignment": ["B" if kind == "B" else "F" for kind in data["edges_assignment"]]}
    )


_STROKES = {"M": "#ed1c24", "V": "#2e3192", "B": "#231f20", "F": "#fff200"}


def _lines(data: Data, look: Callable[[str], str]) -> list[str]:
    found = []
    for (a, b), kind in zip(data["edges_vertices"], data["edges_assignment"], strict=True):
        (x1, y1), (x2, y2) = (data["vertices_coords"][v][:2] for v in (a, b))
        found.append(f'<line {look(kind)} x1="{x1:.4f}" y1="{y1:.4f}" x2="{x2:.4f}" y2="{y2:.4f}"/>')
    return found


def illustrator() -> File:
    """Names of entities in a DOCTYPE, a switch with a private part, styles by class, colours of print."""
    rules = "".join(
        f".st{k}{{fill:none;stroke:{c};stroke-miterlimit:10;}}" for k, c in enumerate(_STROKES.values())
    )
    classes = {kind: f'class="st{k}"' for k, kind in enumerate(_STROKES)}
    body = "".join(_lines(fold_corpus.miura(4, 3), classes.__getitem__))
    text = f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Generator: Adobe Illustrator 24.0.1, SVG Export Plug-In . SVG Version: 6.00 Build 0)  -->
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
  <!ENTITY ns_extend "http://ns.adobe.com/Extensibility/1.0/">
  <!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">
  <!ENTITY ns_svg "http://www.w3.org/2000/svg">
  <!ENTITY ns_xlink "http://www.w3.org/1999/xlink">
]>
<svg version="1.1" xmlns:x="&ns_extend;" xmlns:i="&ns_ai;" xmlns="&ns_svg;" xmlns:xlink="&ns_xlink;" x="0px" y="0px"
  viewBox="0 0 200 200" style="enable-background:new 0 0 200 200;" xml:space="preserve">
<style type="text/css">{rules}</style><metadata><sfw xmlns="&ns_extend;"><slices/></sfw></metadata>
<switch><foreignObject requiredExtensions="&ns_ai;" x="0" y="0" width="1" height="1"><i:pgfRef xlink:href="#a"/>
</foreignObject><g i:extraneous="self"><g id="Layer_1">{body}</g></g></switch></svg>"""
    return "illustrator.svg", text.encode()


def inkscape() -> File:
    """Layers with names, one of them hidden; relative paths of many pieces; defs that nothing draws."""
    data = fold_corpus.miura(4, 3)
    kinds: dict[str, list[str]] = {}
    for (a, b), kind in zip(data["edges_vertices"], data["edges_assignment"], strict=True):
        (x1, y1), (x2, y2) = (data["vertices_coords"][v][:2] for v in (a, b))
        kinds.setdefault(kind, []).append(f"M {x1:.5f},{y1:.5f} l {x2 - x1:.5f},{y2 - y1:.5f}")
    colours = {"M": "#ff0000", "V": "#0000ff", "B": "#000000"}
    layers = "".join(
        f'<g inkscape:groupmode="layer" inkscape:label="{kind}" id="l{kind}" transform="translate(-3,4)">'
        f'<path style="fill:none !important;stroke:{colours[kind]};stroke-opacity:1;stroke-width:0.26458332px" '
        f'd="{" ".join(pieces)}" inkscape:connector-curvature="0"/></g>'
        for kind, pieces in kinds.items()
    )
    text = f"""<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<svg xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd" xmlns="http://www.w3.org/2000/svg"
 xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="210mm" height="297mm" viewBox="0 0 210 297">
<defs><marker id="m"><path stroke="#ff0000" d="M0 0L5 5"/></marker><clipPath id="c"><rect width="9"/></clipPath>
</defs><sodipodi:namedview id="base" pagecolor="#ffffff" bordercolor="#666666"/><g transform="matrix(1 0 0 -1 20 150)">
<g inkscape:groupmode="layer" style="display:none"><path stroke="#0000ff" d="M0 0 100 100"/></g>{layers}</g></svg>"""
    return "inkscape.svg", text.encode()


def simulator() -> File:
    """As patterns for the web: strokes by group, opacity for angles, groups in groups with turns and mirrors."""
    data = fold_corpus.yoshimura(3, 3)
    groups = {
        kind: "".join(
            line for line in _lines(data, lambda k: f'data-kind="{k}"') if f'data-kind="{kind}"' in line
        )
        for kind in "MVB"
    }
    strokes = {"M": "red", "V": "blue", "B": "black"}
    drawn = "".join(
        f'<g stroke="{strokes[kind]}" stroke-opacity="{0.5 if kind != "B" else 1}"><g>{lines}</g></g>'
        for kind, lines in groups.items()
    )
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="20cm" height="20cm" viewBox="-50 -50 300 300">'
        '<g transform="rotate(30 50 50)"><g transform="scale(-1.5 1.5) translate(-120,10)"><g transform="skewX(0)">'
        f"{drawn}</g></g></g></svg>"
    )
    return "simulator.svg", text.encode("utf-16")


def overshot() -> File:
    """A rectangle with creases that go beyond it, in dashes; colours in percent, a title, text, a picture."""
    lines = "".join(
        f'<line x1="{x}" y1="-2" x2="{x}" y2="102" stroke="rgb(100%, 0%, 0%)" stroke-dasharray="4 2 1 2"/>'
        for x in (25, 50, 75)
    )
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="-5 -5 110 110">'
        '<title>pleats</title><rect width="100" height="100" fill="white" stroke="black"/>'
        f'{lines}<text x="3" y="9">fold &amp; glue</text><image xlink:href="data:image/png;base64,iVBORw0KGgo=" '
        'width="9" height="9"/></svg>'
    )
    return "overshot.svg", text.encode()


# With the bodies and hinges that each has: a Miura sheet of 4 x 3 facets 12 and 17, or one less where an edge joins two
# facets; 2 x 2 waterbombs 24 and 29; three rows of six triangles 18 and 21
FILES: dict[str, tuple[Callable[[], File], int, int]] = {
    "unassigned": (unassigned, 12, 17),
    "unassigned inside": (unassigned_inside, 12, 17),
    "faces alone": (faces_alone, 12, 17),
    "folded mesh": (folded_mesh, 12, 17),
    "folded frame": (folded_frame, 24, 29),
    "frames only": (frames_only, 12, 17),
    "own corners": (own_corners, 12, 17),
    "square twist": (square_twist, 9, 12),
    "byte order mark": (byte_order_mark, 12, 17),
    "flat folded": (flat_folded, 12, 17),
    "texts for numbers": (texts_for_numbers, 18, 21),
    "joined edges": (joined_edges, 11, 16),
    "illustrator": (illustrator, 12, 17),
    "inkscape": (inkscape, 12, 17),
    "simulator": (simulator, 18, 21),
    "overshot": (overshot, 4, 3),
}
