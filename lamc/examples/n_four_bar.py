"""The N-four-bar mechanism (IFToMM benchmark A02): text of a mechanism file.

In: how many windows. Out: YAML, the same to the byte for the same number. Never: reads or writes files, simulates.

N + 1 upright rods v0 … vN stand on the ground, 1 m apart, and N level rods h0 … join their tops. All are thin, 1 m long
and of 1 kg. The motion starts upright with every upright rod turning so that the tops move at 1 m/s along x
(M. González et al., A benchmarking system for MBS simulation software, Multibody System Dynamics 16, 2006, 179).
"""

import textwrap

THIN = 1e-7  # kg·m², about a rod's own line, where the benchmark has none: it never turns about it

_HEAD = """\
# The N-four-bar with N = {count}: flat twice a turn, where {moving} ways on are open.
kind: mechanism
name: n_four_bar_{count}
story: >
{story}
"""
_STORY = """\
The N-four-bar of the IFToMM benchmarks (A02), here with N = {count}: {uprights} upright rods joined at their tops by
{count} level ones. It has {loops} and one freedom, and half of the equations are redundant. Twice in each turn all rods
lie in one line; there the rank drops, and each window could flip by itself: {moving} ways on, only one of which is the
motion that came in. A solver that divides by the vanishing pivot blows up, and one that damps it away changes the
branch. Look at the angles of g0 … g{count} where they pass 90 degrees, which must stay equal, and at the energy."""

_SCENE = """\
scene:
  effects:
    gravity: [0, -9.81, 0]
  rates: {g0: -1} # rad/s: the tops move at 1 m/s
"""


def n_four_bar(count: int) -> str:
    """The mechanism of `count` windows (1 or more), upright, with the benchmark's rates."""
    loops = "one loop" if count == 1 else f"{count} loops"
    facts = {"count": count, "moving": count + 1}
    story = _STORY.format(uprights=count + 1, loops=loops, **facts)
    story = textwrap.fill(story, 118, initial_indent="  ", subsequent_indent="  ")
    head = _HEAD.format(story=story, **facts)
    bodies = ["bodies:", "  - {name: ground, fixed: true}"]
    joints = ["joints:"]
    for k in range(count + 1):
        bodies.append(_rod(f"v{k}", (k, 0.5), "y"))
        joints.append(_joint(f"g{k}", "ground", f"v{k}", (k, 0)))
    for k in range(count):
        bodies.append(_rod(f"h{k}", (k + 0.5, 1), "x"))
        joints.append(_joint(f"p{k}", f"v{k}", f"h{k}", (k, 1)))
        joints.append(_joint(f"r{k}", f"h{k}", f"v{k + 1}", (k + 1, 1)))
    return "\n".join([head, *bodies, "", *joints, "", _SCENE])


def _rod(name: str, com: tuple[float, float], along: str) -> str:
    """A thin rod of 1 m and 1 kg: 1/12 kg·m² across."""
    across = "0.083333333333333333"
    moments = [f"{THIN:.1e}" if axis == along else across for axis in "xyz"]
    inertia = f"[[{moments[0]}, 0, 0], [0, {moments[1]}, 0], [0, 0, {moments[2]}]]"
    return f"  - {{name: {name}, mass: 1, com: [{com[0]:g}, {com[1]:g}, 0], inertia: {inertia}}}"


def _joint(name: str, parent: str, child: str, at: tuple[float, float]) -> str:
    place = f"point: [{at[0]:g}, {at[1]:g}, 0], axis: [0, 0, 1]"
    return f"  - {{name: {name}, parent: {parent}, child: {child}, {place}}}"
