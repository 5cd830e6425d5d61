"""Crease patterns as other programs write them, seeded: what is missing, doubled, odd, and all the same a pattern.

In: a seed. Out: a name, the text of a file, whether it is a crease pattern that a sheet can be made of.
"""

import json
import random
from collections.abc import Callable
from typing import Any

from tests.support import fold_corpus

Data = dict[str, Any]
PATTERNS: dict[str, Callable[[], Data]] = {
    "miura": lambda: fold_corpus.miura(4, 3),
    "waterbomb": fold_corpus.waterbomb,
    "yoshimura": lambda: fold_corpus.yoshimura(3, 3),
    "kresling": lambda: fold_corpus.kresling(4, 3),
    "box": fold_corpus.box_net,
}
COLOURS = {"M": "#ff0000", "V": "blue", "B": "#000", "C": "rgb(0, 255, 0)", "F": "#FFFF00", "U": "magenta"}
DOCTYPE = (
    '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">\n'
)


def fold_file(seed: int) -> tuple[str, str]:
    """A FOLD file as a tool may write it."""
    chance = random.Random(seed)
    name = chance.choice(sorted(PATTERNS))
    data = dict(PATTERNS[name]())
    edges, kinds = list(data["edges_vertices"]), list(data["edges_assignment"])
    points = [list(point) for point in data["vertices_coords"]]
    if chance.random() < 0.5:
        data.pop("frame_unit", None)
    if chance.random() < 0.4:
        points = [[*point[:2], 0.0] for point in points]
        data["frame_attributes"] = ["3D"]
    if chance.random() < 0.3:
        points.append([*(-7.0 for _ in points[0][:2]), *points[0][2:]])  # a vertex of no edge
    if chance.random() < 0.3:
        at = chance.randrange(len(edges))
        kinds[at] = "U" if kinds[at] in "MV" else kinds[at]
    if chance.random() < 0.3:
        at = chance.randrange(len(edges))
        edges.append(edges[at][::-1])  # drawn twice
        kinds.append(kinds[at])
        if "edges_foldAngle" in data:
            data["edges_foldAngle"] = [*data["edges_foldAngle"], data["edges_foldAngle"][at]]
    if chance.random() < 0.3:
        kinds = [kind.lower() if chance.random() < 0.2 else kind for kind in kinds]
    if chance.random() < 0.3:
        data["edges_foldAngle"] = [None if kind.upper() == "B" else 0.0 for kind in kinds]
    if chance.random() < 0.2:
        kinds = []
    data |= {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": kinds}
    if not kinds:
        del data["edges_assignment"]
        data.pop("edges_foldAngle", None)
    if chance.random() < 0.3:
        data["file_frames"] = [{"frame_classes": ["foldedForm"], "frame_parent": 0, "frame_inherit": True}]
    data |= {"file_creator": "a tool", "tool:grid": [1, 2], "vertices_vertices": [[] for _ in points]}
    if chance.random() < 0.5:
        del data["vertices_vertices"]
    return f"{name}{seed}.fold", json.dumps(data)


def svg_file(seed: int) -> tuple[str, str]:
    """An SVG file as programs for drawing write it."""
    chance = random.Random(seed)
    name = chance.choice(sorted(PATTERNS))
    data = PATTERNS[name]()
    by_class = chance.random() < 0.5
    noise = chance.choice([0.0, 1e-4, 1e-3])
    lines = []
    for (a, b), kind in zip(data["edges_vertices"], data["edges_assignment"], strict=True):
        (x1, y1), (x2, y2) = (
            [c + chance.uniform(-noise, noise) for c in data["vertices_coords"][v][:2]] for v in (a, b)
        )
        angle = (
            "" if kind not in "MV" or chance.random() < 0.5 else f' opacity="{chance.choice([0.25, 0.5, 1])}"'
        )
        look = (
            f'class="k{kind}"' if by_class else f'style="stroke:{COLOURS[kind]};stroke-width:0.5;fill:none"'
        )
        if chance.random() < 0.3:
            lines.append(f'<path {look}{angle} d="M{x1:.6g},{y1:.6g}L{x2:.6g} {y2:.6g}"/>')
        elif chance.random() < 0.3:
            lines.append(f'<polyline {look}{angle} points="{x1:.6g},{y1:.6g} {x2:.6g},{y2:.6g}"/>')
        else:
            lines.append(f'<line {look}{angle} x1="{x1:.6g}" y1="{y1:.6g}" x2="{x2:.6g}" y2="{y2:.6g}"/>')
    chance.shuffle(lines)
    while len(lines) > 3 and chance.random() < 0.6:
        cut = chance.randrange(1, len(lines))
        lines = [
            f'<g id="Layer_{len(lines)}" transform="translate(1e-9 0)">',
            *lines[:cut],
            "</g>",
            *lines[cut:],
        ]
    rules = "".join(f".k{kind}{{fill:none;stroke:{colour}}}" for kind, colour in COLOURS.items())
    sheet = f"<style><![CDATA[{rules}]]></style>" if by_class else ""
    size = chance.choice(['width="200mm" height="200mm"', 'width="200px" height="200px"', 'width="100%"', ""])
    text = (
        f'<?xml version="1.0" encoding="utf-8"?>\n{DOCTYPE if chance.random() < 0.6 else ""}'
        f'<svg version="1.1" xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 200 200" xml:space="preserve">'
        f"<title>{name}</title>{sheet}{''.join(lines)}</svg>"
    )
    return f"{name}{seed}.svg", text
