"""The colours of bodies, in pictures and in models for other programs alike.

In: a mechanism. Out: colours as "#rrggbb". Never: draws.
"""

from lamc.records.mechanism import Mechanism

# Okabe and Ito's palette, which readers of all kinds of colour vision can tell apart; grey is for the world.
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442")
WORLD = "#9A9A9A"


def body_colours(mechanism: Mechanism) -> dict[str, str]:
    """A colour per body: grey for the world, and different ones for bodies that share a hinge."""
    neighbours: dict[str, set[str]] = {body.name: set() for body in mechanism.bodies}
    for joint in mechanism.joints:
        neighbours[joint.parent].add(joint.child)
        neighbours[joint.child].add(joint.parent)
    colours: dict[str, str] = {}
    moving = 0
    for body in mechanism.bodies:
        if body.fixed:
            colours[body.name] = WORLD
            continue
        near = {colours[name] for name in neighbours[body.name] if name in colours}
        rotated = [PALETTE[(moving + k) % len(PALETTE)] for k in range(len(PALETTE))]
        colours[body.name] = next((c for c in rotated if c not in near), rotated[0])
        moving += 1
    return colours
