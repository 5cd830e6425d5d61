"""Options of exports: one that has no effect, by itself or beside others, is refused, with advice that is right."""

import importlib.util
import re
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from shapely.geometry import MultiPolygon, box

from lamc import Body, Design, ExportError, ExternalTorque, Joint, Material, Mechanism, Scene, Slab
from lamc.design.mass import body_properties
from lamc.export import TARGETS, Files, files_of
from lamc.export.options import ExportOptions, options_from
from lamc.records.design import HingeLine, HingeSet, Layer
from tests.support.ctools import needs_cc

pytestmark = pytest.mark.usefixtures("unpainted")

# A value of each that is not its default. `lossy` is missing: it permits, and permission may go unused.
CHOSEN: Mapping[str, object] = {
    "prefix": "other",
    "precision": "float",
    "integrator": "rk45",
    "real_time": True,
    "jacobian": False,
    "libm": False,
    "single_header": True,
    "fmi": 3,
    "inputs": "none",
    "step": 1e-4,
    "edge_length": 1e-3,
    "hinge_style": "castellated",
    "hinge_width": "gap",
    "kerf": 1e-5,
    "pins": 3e-3,
    "stock": (0.3, 0.2),
}
has_zig = importlib.util.find_spec("ziglang") is not None
BUILT = [
    pytest.param(name, marks=[needs_cc] if name in ("fmu", "wheel") else [])
    for name in TARGETS
    if name != "wasm" or has_zig
]


def flap() -> Mechanism:
    wall, body = Body("wall", fixed=True), Body("flap", 0.01, (0.02, 0.0, 0.0), np.diag([2e-5] * 3))
    return Mechanism((wall, body), (Joint("h", "wall", "flap", axis=(0.0, 0.0, 1.0)),), name="flap")


def laminate() -> Design:
    """Two boards on a film; the boards are drawn over the gap of their hinge."""
    board, film = Material("board", 1000.0, is_rigid=True), Material("film", 1000.0, is_flexible=True)
    whole = MultiPolygon([box(0.0, 0.0, 0.04, 0.02)])
    layers = (Layer("board", board, 3e-4, whole), Layer("film", film, 25e-6, whole))
    hinge = HingeSet((HingeLine(((0.02, 0.0), (0.02, 0.02)), "h"),), 5e-4, 1, (0, 1))
    return Design("flap", layers, (hinge,), (MultiPolygon([box(0.0, 0.0, 0.01, 0.02)]), MultiPolygon()))


def sheet() -> Mechanism:
    """Two facets of one card with a common side, as FOLD needs them."""
    bodies = []
    for name, x in (("wall", 0.0), ("flap", 0.02)):
        slab = Slab(box(x, 0.0, x + 0.02, 0.02), 0.0, 3e-4)
        bodies.append(Body(name, *body_properties([(slab, 700.0)]), name == "wall", (slab,)))
    joint = Joint("h", "wall", "flap", (0.02, 0.0, 1.5e-4), (0.0, -1.0, 0.0))
    return Mechanism(tuple(bodies), (joint,), name="flap", scene=Scene(duration=0.1))


@cache
def made(target: str, names: frozenset[str]) -> Files | None:
    """The export with these chosen; None where it is refused, with one line that names one of them."""
    try:
        design = {"fold": sheet, "cut": laminate}.get(target, flap)()
        return files_of(design, target, options=options_from(**{name: CHOSEN[name] for name in names}))
    except ExportError as error:
        reported = str(error)
    assert any(re.search(rf"\({name}\)|\b{name}:", reported) for name in names)
    assert "\n" not in reported
    return None


def test_every_option_is_tried() -> None:
    assert set(CHOSEN) | {"lossy"} == set(ExportOptions.__dataclass_fields__)
    assert all(getattr(ExportOptions(), name) != value for name, value in CHOSEN.items())


@pytest.mark.parametrize("target", BUILT)
@pytest.mark.quick("mjcf", "urdf", "cut", others="campaign")
def test_an_option_that_changes_no_byte_is_refused(target: str) -> None:
    plain = made(target, frozenset())
    assert plain is not None
    for name in CHOSEN:
        chosen = made(target, frozenset({name}))
        assert chosen is None or chosen != plain, name
        assert (chosen is None) == (name not in TARGETS[target].uses or name == "precision")


def sets() -> Iterator[frozenset[str]]:
    """All pairs, and all that can stand beside single precision, which needs steps of fixed length."""
    yield from (frozenset(pair) for pair in combinations(CHOSEN, 2))
    yield from (frozenset({"precision", "real_time", name}) for name in CHOSEN)


@pytest.mark.parametrize("target", [pytest.param("c", marks=pytest.mark.slow), "mjcf", "urdf"])
def test_nor_is_one_accepted_that_others_leave_nothing_to_do(target: str) -> None:
    for names in sets():
        both = made(target, names)
        if both is None:
            continue
        for name in names:
            assert both != made(target, names - {name}), (name, sorted(names))


@pytest.mark.parametrize(
    ("first", "second", "reported"),
    [
        ("real_time", "integrator", r"--integrator \(integrator\) is 'rk45'.*--real-time \(real_time\)"),
        ("precision", "libm", r"--real-time"),
    ],
)
def test_a_refusal_of_two_names_both(first: str, second: str, reported: str) -> None:
    with pytest.raises(ExportError, match=reported):
        files_of(flap(), "c", options=options_from(**{name: CHOSEN[name] for name in (first, second)}))


def test_single_precision_brings_its_functions_along() -> None:
    options = options_from(precision="float", real_time=True, libm=False)
    with pytest.raises(ExportError, match=r"--no-libm \(libm\).*--float \(precision\)"):
        files_of(flap(), "c", options=options)


@pytest.mark.parametrize("target", [name for name in TARGETS if "precision" not in TARGETS[name].uses])
def test_single_precision_elsewhere_is_not_advised_what_is_refused_next(target: str) -> None:
    """Only C can be of floats, and steps of fixed length do not make it of another target."""
    with pytest.raises(ExportError) as caught:
        files_of(flap(), target, options=ExportOptions(precision="float"))
    assert "--real-time" not in str(caught.value)
    assert f"{target} has no use for it; leave it out (it is for c)" in str(caught.value)


@pytest.mark.parametrize(
    "scene", [Scene(added=(ExternalTorque(("h",)),)), Scene(without=("external_torque",))]
)
def test_torques_from_outside_are_chosen_once(scene: Scene) -> None:
    with pytest.raises(ExportError, match=r"external_torque.*leave out one"):
        files_of(flap(), "c", scene, ExportOptions(inputs="none"))
