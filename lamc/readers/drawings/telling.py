"""How messages about a drawing name its lines, places and mends.

In: strokes, places, mends. Out: text. Never: decides anything.
"""

from collections import Counter
from collections.abc import Iterable, Sequence

from lamc.records.drawing import Mend, Stroke


def name_of(strokes: Sequence[Stroke], k: int) -> str:
    """What the file calls a stroke, else its number."""
    return strokes[k].source or f"line {k}"


def names_of(strokes: Sequence[Stroke], numbers: Iterable[int]) -> str:
    """The same of a few, each name once."""
    named = dict.fromkeys(name_of(strokes, k) for k in sorted(set(numbers)))
    return " and ".join(list(named)[:3]) + (", …" if len(named) > 3 else "")


def millimetres(at: Iterable[float]) -> str:
    """A place, m, as "(12.5, 3) mm"."""
    x, y = (round(1e3 * float(value), 6) + 0.0 for value in at)
    return f"({x:.7g}, {y:.7g}) mm"


def mend_notes(mends: Sequence[Mend], tolerance: float, option: str = "--heal") -> list[str]:
    """A line for each kind of mend: how many, how far, where the first ones are. option: what sets the tolerance."""
    lines = []
    for what, count in sorted(Counter(mend.what for mend in mends).items()):
        found = [mend for mend in mends if mend.what == what]
        far = max(mend.moved for mend in found)
        by = f", by up to {1e3 * far:.3g} mm" if far else ""
        shown = "; ".join(f"{millimetres(m.at)}, {m.source}" for m in found[:3])
        lines.append(f"healed: {what}: {count}{by}: {shown}{'; …' if count > 3 else ''}")
    if lines:
        lines[0] += f" (healed within {1e3 * tolerance:.3g} mm; {option} says another)"
    return lines


def full_notes(strokes: Iterable[Stroke]) -> list[str]:
    """A line for creases that rest folded flat because nothing makes them fainter; [] where there are none."""
    count = sum(stroke.full for stroke in strokes)
    if not count:
        return []
    have = "crease has full opacity and rests" if count == 1 else "creases have full opacity and rest"
    return [
        f"{count} {have} at 180 degrees, folded flat, on the way to which facets may pass through one another "
        "(stroke-opacity 0.5 rests at 90)"
    ]
