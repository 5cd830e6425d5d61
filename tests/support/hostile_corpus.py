"""Drawings that try a reader hard: very many lines, crossings, gaps, windows, creases at one vertex.

In: a folder, a size. Out: a FOLD or SVG file.
"""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.support import fold_corpus, large_corpus, svg_corpus


def fan(folder: Path, count: int = 500) -> Path:
    """A disc with `count` creases that meet in its middle."""
    rim = [
        (50.0 * math.cos(math.tau * k / count), 50.0 * math.sin(math.tau * k / count)) for k in range(count)
    ]
    data = fold_corpus._started([(0.0, 0.0), *rim], "mm")
    for k in range(count):
        fold_corpus._edge(data, k + 1, (k + 1) % count + 1, "B")
        fold_corpus._edge(data, 0, k + 1, "MV"[k % 2])
    return fold_corpus.write(folder / f"fan_{count}.fold", data)


def _svg(folder: Path, name: str, body: list[str], width: float = 100.0) -> Path:
    size = f'width="{width:g}mm" height="{width:g}mm" viewBox="0 0 {width:g} {width:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>'
    file = folder / f"{name}.svg"
    file.write_text(
        "\n".join([head, '<g fill="none" stroke="black">', *body, "</g>", "</svg>"]), encoding="utf-8"
    )
    return file


_RIM = '<rect width="100" height="100"/>'


def crossed_grid(folder: Path, count: int) -> Path:
    """`count` level and `count` upright creases across a square: count² crossings that the drawing has no point at."""
    places = [100.0 * (k + 1) / (count + 1) for k in range(count)]
    lines = [
        f'<path stroke="red" d="M0 {at:.6f}H100"/><path stroke="blue" d="M{at:.6f} 0V100"/>' for at in places
    ]
    return _svg(folder, f"crossed_{count}", [_RIM, *lines])


def random_lines(folder: Path, count: int) -> Path:
    """Creases from edge to edge in all directions, which cross one another everywhere."""
    chance = np.random.default_rng(3)
    lines = []
    for a, b in chance.uniform(0.0, 100.0, (count, 2)):
        lines.append(f'<path stroke="red" d="M0 {a:.6f}L100 {b:.6f}"/>')
    return _svg(folder, f"random_{count}", [_RIM, *lines])


def doubled(folder: Path, size: int, times: int) -> Path:
    """A Miura sheet whose lines are drawn several times, each time off by micrometres."""
    data = large_corpus.miura(size, size)
    text = svg_corpus.svg(data)
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    copies = [f'<g transform="translate({1e-3 * k} {5e-4 * k})">{body}</g>' for k in range(times)]
    file = folder / f"doubled_{size}_{times}.svg"
    file.write_text(text.replace(body, "\n".join(copies)), encoding="utf-8")
    return file


def gaps(folder: Path, size: int) -> Path:
    """A grid of creases, each drawn from vertex to vertex and short of them by some micrometres."""
    chance = np.random.default_rng(5)
    step, lines = 100.0 / size, []
    for j in range(size + 1):
        for i in range(size):
            off = chance.uniform(-4e-3, 4e-3, 8)
            for k, (a, b, c, d) in enumerate(((i, j, i + 1, j), (j, i, j, i + 1))):
                x1, y1, x2, y2 = (np.array([a, b, c, d]) * step + off[4 * k : 4 * k + 4]).tolist()
                stroke = "black" if j in (0, size) else ("red", "blue")[k]
                lines.append(
                    f'<line stroke="{stroke}" x1="{x1:.5f}" y1="{y1:.5f}" x2="{x2:.5f}" y2="{y2:.5f}"/>'
                )
    return _svg(folder, f"gaps_{size}", lines)


def spiral(folder: Path, count: int, role: str = "red") -> Path:
    """One polyline of very many points, from the middle of a square outwards."""
    places = []
    for k in range(count):
        turn, radius = math.tau * math.sqrt(k) / 8.0, 45.0 * math.sqrt((k + 1) / count)
        places.append(f"{50 + radius * math.cos(turn):.5f},{50 + radius * math.sin(turn):.5f}")
    return _svg(
        folder, f"spiral_{role}_{count}", [_RIM, f'<polyline stroke="{role}" points="{" ".join(places)}"/>']
    )


def round_outline(folder: Path, count: int) -> Path:
    """A disc whose rim has very many corners, with one crease."""
    turns = [math.tau * k / count for k in range(count)]
    rim = [f"{50 + 45 * math.cos(turn):.6f},{50 + 45 * math.sin(turn):.6f}" for turn in turns]
    return _svg(
        folder, f"rim_{count}", [f'<polygon points="{" ".join(rim)}"/>', '<path stroke="red" d="M5 50H95"/>']
    )


def strip(folder: Path, count: int) -> Path:
    """A strip of `count` facets in a row: no loop, and `count` - 1 freedoms."""
    data = large_corpus.miura(count, 1)
    return fold_corpus.write(folder / f"strip_{count}.fold", data)


def waves(folder: Path, count: int) -> Path:
    """Curved creases across a square, mountains and valleys by turns."""
    lines = []
    for k in range(count):
        y = 100.0 * (k + 1) / (count + 1)
        d = f"M0 {y:.4f}C30 {y - 25:.4f} 60 {y + 25:.4f} 100 {y:.4f}"
        lines.append(f'<path stroke="{("red", "blue")[k % 2]}" stroke-opacity="0.5" d="{d}"/>')
    return _svg(folder, f"waves_{count}", [_RIM, *lines])


def windows(folder: Path, size: int) -> Path:
    """A square with a crease and size² round windows."""
    step = 100.0 / size
    holes = [
        f'<circle cx="{(i + 0.5) * step:.4f}" cy="{(j + 0.5) * step:.4f}" r="{0.3 * step:.4f}"/>'
        for i in range(size)
        for j in range(size)
    ]
    return _svg(folder, f"windows_{size}", [_RIM, '<path stroke="red" d="M0 50.001H100"/>', *holes])


def specks(folder: Path, count: int) -> Path:
    """Marks shorter than the tolerance all over a sheet of one crease."""
    chance = np.random.default_rng(7)
    marks = [
        f'<path stroke="red" d="M{x:.4f} {y:.4f}h.004"/>' for x, y in chance.uniform(1.0, 99.0, (count, 2))
    ]
    return _svg(folder, f"specks_{count}", [_RIM, '<path stroke="red" d="M0 50H100"/>', *marks])


def stitches(folder: Path, count: int) -> Path:
    """Creases across a square, drawn as dashes that hang loose."""
    lines = []
    for k in range(1, count):
        y = 100.0 * k / count
        starts = range(5, 1000, max(1, count // 10))
        lines += [f'<path stroke="red" d="M{x / 10:.2f} {y:.4f}h0.05"/>' for x in starts]
    return _svg(folder, f"stitches_{count}", [_RIM, *lines])


def fold_grid(folder: Path, size: int) -> Path:
    """A FOLD file of a square grid, size² facets, without faces."""
    data = large_corpus.grid(size, size)
    for key in ("faces_vertices", "edges_foldAngle"):
        del data[key]
    return fold_corpus.write(folder / f"grid_{size}.fold", data)


HOSTILE: dict[str, Callable[[Path], Path]] = {
    "fan of 500 creases": lambda folder: fan(folder, 500),
    "fan of 60 creases": lambda folder: fan(folder, 60),
    "strip of 200 facets": lambda folder: strip(folder, 200),
    "strip of 2000 facets": lambda folder: strip(folder, 2000),
    "30 x 30 lines across": lambda folder: crossed_grid(folder, 30),
    "150 x 150 lines across": lambda folder: crossed_grid(folder, 150),
    "1000 x 1000 lines across": lambda folder: crossed_grid(folder, 1000),
    "16 random lines": lambda folder: random_lines(folder, 16),
    "100 random lines": lambda folder: random_lines(folder, 100),
    "3000 random lines": lambda folder: random_lines(folder, 3000),
    "Miura 16x16, drawn 5 times": lambda folder: doubled(folder, 16, 5),
    "Miura 32x32, drawn 30 times": lambda folder: doubled(folder, 32, 30),
    "grid of 20 with gaps": lambda folder: gaps(folder, 20),
    "grid of 100 with gaps": lambda folder: gaps(folder, 100),
    "spiral of 1e4 points": lambda folder: spiral(folder, 10_000),
    "spiral of 9e4 points": lambda folder: spiral(folder, 90_000),
    "spiral of 1e6 points": lambda folder: spiral(folder, 1_000_000),
    "cut spiral of 9e4 points": lambda folder: spiral(folder, 90_000, "#00ff00"),
    "rim of 9e4 points": lambda folder: round_outline(folder, 90_000),
    "6 waves": lambda folder: waves(folder, 6),
    "20 waves": lambda folder: waves(folder, 20),
    "200 waves": lambda folder: waves(folder, 200),
    "900 windows": lambda folder: windows(folder, 30),
    "4900 windows": lambda folder: windows(folder, 70),
    "20000 specks": lambda folder: specks(folder, 20_000),
    "10000 stitches": lambda folder: stitches(folder, 100),
    "FOLD grid of 1e4 edges": lambda folder: fold_grid(folder, 58),
    "FOLD grid of 1e5 edges": lambda folder: fold_grid(folder, 182),
    "FOLD grid of 1e6 edges": lambda folder: fold_grid(folder, 577),
}
