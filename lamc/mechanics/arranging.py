"""`arrange`: what the effects of a scene ask for beyond the angles of the hinges, as one `Arrangement`.

Goes in: a tree and the effects; each has the hook `arrange(arranging)`. Comes out: an `Arrangement`, or a DesignError
that names the effects which do not go together, or not with the mechanism.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.mechanics.arrangement import Arrangement, Bushing, FloatingBase, PrescribedBase
from lamc.mechanics.compliant_hinge import CompliantHinge, check_bushing
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanism.tree import Tree
from lamc.records.effect import asked, hooked
from lamc.records.network import listed_names

if TYPE_CHECKING:
    from lamc.records.effect import Effect


class Arranging:
    """What the method `arrange(arranging)` of an effect is given: it adds coordinates here, or prescribes them.

    Each method raises DesignError where the mechanism does not allow it, or where another effect did it already.
    """

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.effect = ""  # the name of the effect that is being asked
        self._base: FloatingBase | PrescribedBase | None = None
        self._compliant: dict[str, CompliantHinge] = {}
        self._flexible: dict[str, FlexibleBody] = {}
        self._gears: dict[str, str] = {}  # joint → effect
        self._inverse_dynamics = False

    def move_base(self, base: FloatingBase | PrescribedBase) -> None:
        """The fixed bodies move, freely or as prescribed."""
        if self._base is not None:
            raise DesignError(
                f"effects {self._base.effect!r} and {self.effect!r} both move the fixed bodies; leave one out"
            )
        self._base = replace(base, effect=self.effect)

    def compliant_hinge(self, hinge: CompliantHinge) -> None:
        """A hinge yields across its axis: in the tree it gains coordinates, if it closes a loop it is a bushing."""
        joints = {joint.name: joint for joint in self.tree.mechanism.joints}
        if hinge.joint not in joints:
            raise DesignError(
                f"no joint is named {hinge.joint!r}; the joints are {listed_names(sorted(joints))}"
            )
        if hinge.joint in self._compliant:
            raise DesignError(f"two effects make joint {hinge.joint!r} compliant; leave one out")
        if not np.allclose(hinge.axes[:, 2], joints[hinge.joint].axis, rtol=0.0, atol=1e-9):
            raise DesignError(
                f"the z axis of the compliant hinge {hinge.joint!r} is not the joint's axis; turn the axes"
            )
        self._compliant[hinge.joint] = replace(hinge, effect=self.effect)

    def flexible_body(self, body: FlexibleBody) -> None:
        """A body of the tree bends in the modes given."""
        moving = {link.body.name for link in self.tree.links}
        if body.body not in moving:
            raise DesignError(
                f"no moving body is named {body.body!r}; they are {listed_names(sorted(moving))}"
            )
        if body.body in self._flexible:
            raise DesignError(f"two effects make body {body.body!r} flexible; leave one out")
        self._flexible[body.body] = replace(body, effect=self.effect)

    def gear(self, joint: str) -> None:
        """The gear on a joint turns by itself, with an angle like the joint's; see `gears.py`."""
        joints = [each.name for each in self.tree.mechanism.joints]
        if joint not in joints:
            raise DesignError(f"no joint is named {joint!r}; the joints are {listed_names(sorted(joints))}")
        if joint in self._gears:
            raise DesignError(
                f"effects {self._gears[joint]!r} and {self.effect!r} both put a gear on joint {joint!r}"
            )
        self._gears[joint] = self.effect

    def inverse_dynamics(self) -> None:
        """The equations are to be in the general form, which `Loads.added_inertia` needs."""
        self._inverse_dynamics = True

    def arranged(self) -> Arrangement:
        """What the effects asked for."""
        links, cuts = self.tree.links, self.tree.cuts
        yielding = {cut.joint.name for cut in cuts} & set(self._compliant)
        bushings = tuple(Bushing(c, self._compliant[c.joint.name]) for c in cuts if c.joint.name in yielding)
        for bushing in bushings:
            check_bushing(bushing.hinge)
        tree = replace(self.tree, cuts=tuple(c for c in cuts if c.joint.name not in yielding))
        arrangement = Arrangement(
            tree=tree if bushings else self.tree,
            base=self._base,
            compliant=tuple(self._compliant[n] for n in self.tree.joint_names if n in self._compliant),
            bushings=bushings,
            flexible=tuple(
                self._flexible[link.body.name] for link in links if link.body.name in self._flexible
            ),
            gears=tuple(joint.name for joint in tree.hinges if joint.name in self._gears),
            inverse_dynamics=self._inverse_dynamics,
        )
        _check_names(arrangement)
        return arrangement


def arrange(tree: Tree, effects: "Iterable[Effect | Any]") -> Arrangement:
    """What the effects of a scene make of `tree`. Raises DesignError where they do not fit it."""
    arranging = Arranging(tree)
    for effect in effects:
        arranging.effect = effect.name
        with asked(effect):
            hooked(effect).arrange(arranging)
    return arranging.arranged()


def _check_names(arrangement: Arrangement) -> None:
    """Coordinates that effects add are named after joints and bodies, and must not meet a joint's own name."""
    names = [c.name for c in arrangement.coordinates]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise DesignError(
            f"a joint is named {twice!r}, as a coordinate is that an effect adds; rename the joint"
        )
