"""Electric fields, gaps, sandwiches, layup notation, shear through the thickness, and the library of materials."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plate import Laminate, Material, Ply
from lamc.plates.laminates.layup import MOST_PLIES, layup_angles
from lamc.plates.laminates.shear import shear_compliance

STEEL = plate.material("steel")
T300 = plate.material("T300/5208")
PZT = plate.material("PZT-5A")
# Sums of a few products of like size, each rounded once: some ulp.
ROUND_OFF = 1e-13

# --- electric fields -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reference", ["middle", "bottom", 3e-4])
def test_bimorph_bends_as_in_closed_form(reference: str | float) -> None:
    """Two like layers of h/2 in opposite fields: κ = 3 d31 E / h in both directions (J. G. Smits and W. Choi, IEEE
    Trans. UFFC 38 (1991) 256, without load). d31 < 0, so a field up shortens the upper layer, and the plate turns its
    hollow side up."""
    h, field = 0.4e-3, 2e5
    bimorph = Laminate([Ply(PZT, h / 2), Ply(PZT, h / 2)], reference)
    bent = bimorph.deformation(fields=(-field, field))
    kappa = 3 * PZT.d31 * field / h
    assert kappa < 0
    assert bent.curvature == pytest.approx([kappa, kappa, 0], rel=1e-11, abs=1e-11 * abs(kappa))
    states = bimorph.ply_states(bent.strain, bent.curvature, fields=(-field, field))
    # There is stress, for the layers hinder each other; its resultant vanishes, since nothing acts on the plate.
    force = sum(s.ply.thickness * s.stress.mean(axis=0) for s in states)
    assert force == pytest.approx(np.zeros(3), abs=1e-10 * PZT.E1 * abs(PZT.d31) * field * h)


def test_free_piezoelectric_ply_has_its_strain_and_no_stress() -> None:
    """Strains d31 E and d32 E along its own axes, turned by the ply angle."""
    film = Material(3e9, 2e9, 0.3, 1e9, 1780.0, d31=23e-12, d32=3e-12)
    laminate = Laminate([Ply(film, 1e-4, 90.0)])
    free = laminate.deformation(fields=1e6)
    assert free.strain == pytest.approx([3e-6, 23e-6, 0], rel=1e-12, abs=1e-18)
    (state,) = laminate.ply_states(free.strain, free.curvature, fields=1e6)
    assert np.abs(state.stress).max() < 1e-12 * 3e9 * 23e-6


def test_one_field_for_all_plies_leaves_those_without_piezoelectricity_alone() -> None:
    laminate = Laminate([Ply(STEEL, 1e-4), Ply(PZT, 2e-4, 30.0)])
    one, each = laminate.expansion(fields=3e5), laminate.expansion(fields=(7e8, 3e5))
    np.testing.assert_array_equal(one.force, each.force)
    held = PZT.E1 / (1 - PZT.nu12) * PZT.d31 * 3e5 * 2e-4  # of a sheet that is kept from stretching
    assert one.force == pytest.approx([held, held, 0], rel=1e-12, abs=1e-12 * abs(held))
    assert one.moment[:2] == pytest.approx(held * np.full(2, 0.5e-4), rel=1e-12)


def test_expansions_add_up() -> None:
    laminate = Laminate([Ply(T300, 1e-4, 20), Ply(PZT, 2e-4)])
    together = laminate.expansion(30.0, 0.01, 1e5)
    parts = [laminate.expansion(30.0), laminate.expansion(0.0, 0.01), laminate.expansion(fields=1e5)]
    size = np.abs([part.force for part in parts]).max()
    np.testing.assert_allclose(together.force, sum(p.force for p in parts), rtol=0, atol=ROUND_OFF * size)
    np.testing.assert_allclose(
        together.moment, sum(p.moment for p in parts), rtol=0, atol=ROUND_OFF * size * 3e-4
    )


# --- sections --------------------------------------------------------------------------------------------------------


def test_gap_is_a_ply_without_stiffness_and_mass() -> None:
    """A, B and D of two sheets at a distance are those of the stack with a vanishing filling."""
    hollow = Laminate([Ply(T300, 1e-4, 30), Ply(STEEL, 2e-4, gap=5e-4)])
    nothing = Material(1e-3, 1e-3, 0.0, 1e-3, 0.0)  # 1e-14 of the sheets' stiffness
    filled = Laminate([Ply(T300, 1e-4, 30), Ply(nothing, 5e-4), Ply(STEEL, 2e-4)])
    assert hollow.thickness == pytest.approx(8e-4, rel=1e-15)
    assert hollow.areal_mass == filled.areal_mass
    for one, other in ((hollow.A, filled.A), (hollow.B, filled.B), (hollow.D, filled.D)):
        np.testing.assert_allclose(one, other, rtol=0, atol=ROUND_OFF * np.abs(other).max())
    np.testing.assert_allclose(hollow.interfaces, filled.interfaces, rtol=0, atol=1e-18)
    np.testing.assert_allclose(hollow.heights, filled.heights[[0, 2]], rtol=0, atol=1e-18)


def test_regions_with_one_reference_share_their_heights() -> None:
    """The film of a hinge, 25 µm, on a sheet of 500 µm, seen alone and within the stack: z is the same, and so is what
    it adds to A, B and D."""
    film, board = Ply(plate.material("Kapton HN"), 25e-6), Ply(plate.material("Mylar"), 500e-6)
    stack = Laminate([film, board])
    alone = Laminate.layer(film.material, 25e-6, height=stack.heights[0].mean())
    rest = Laminate.layer(board.material, 500e-6, height=stack.heights[1].mean())
    assert alone.heights[0] == pytest.approx(stack.heights[0], rel=1e-12)
    for part, other, whole in (
        (alone.A, rest.A, stack.A),
        (alone.B, rest.B, stack.B),
        (alone.D, rest.D, stack.D),
    ):
        np.testing.assert_allclose(
            part + other, whole, rtol=0, atol=ROUND_OFF * np.abs(part + other).max() * 10
        )


def test_sandwich_is_its_face_its_core_and_its_face_again() -> None:
    face, core = [Ply(T300, 1e-4, 0), Ply(T300, 1e-4, 45)], Ply(STEEL, 1e-3)
    assert [ply.angle for ply in Laminate.sandwich(face, core).plies] == [0, 45, 0, 45, 0]
    assert Laminate.sandwich(face, core).plies[2] is core
    assert Laminate.sandwich(face[0], core, "bottom") == Laminate([face[0], core, face[0]], "bottom")


# --- shear through the thickness -------------------------------------------------------------------------------------


def test_homogeneous_strip_has_five_sixths_of_its_shear_stiffness() -> None:
    """S = 5/6 G h, however many plies it is cut into."""
    for plies in ([Ply(STEEL, 2e-3)], [Ply(STEEL, 0.5e-3, angle) for angle in (0, 45, 90, 10)]):
        compliance, D = shear_compliance(plies, 0.0)
        assert 1 / compliance == pytest.approx(5 / 6 * STEEL.G12 * 2e-3, rel=1e-12)
        assert pytest.approx(210e9 * 2e-3**3 / 12 / (1 - 0.09), rel=1e-12) == D


def test_soft_core_between_thin_faces_shears_as_in_closed_form() -> None:
    """S = G d²/c for faces of thickness t << c, with d = c + t (H. G. Allen, Analysis and Design of Structural Sandwich
    Panels, 1969, section 2.5)."""
    t, c = 1e-6, 10e-3
    core = Material.isotropic(E=1e3, nu=0.3, density=50)
    plies = Laminate.sandwich(Ply(STEEL, t), Ply(core, c)).plies
    compliance, _ = shear_compliance(plies, 0.0)
    # The core's own bending stiffness is of order E_c c / (E t) = 5e-5 of the faces', the faces' own of order t/c.
    assert 1 / compliance == pytest.approx(core.G12 * (c + t) ** 2 / c, rel=3e-4)


def test_shear_takes_the_modulus_of_its_plane() -> None:
    ply = Material(E1=100e9, E2=10e9, nu12=0.3, G12=5e9, density=1, G13=4e9, G23=2e9)
    for angle, G in ((0.0, 4e9), (90.0, 2e9), (45.0, 3e9)):
        compliance, _ = shear_compliance([Ply(ply, 1e-3, angle)], 0.0)
        assert 1 / compliance == pytest.approx(5 / 6 * G * 1e-3, rel=1e-12)
    unknown = Material(E1=100e9, E2=10e9, nu12=0.3, G12=5e9, density=1)
    assert 1 / shear_compliance([Ply(unknown, 1e-3)], 0.0)[0] == pytest.approx(5 / 6 * 5e9 * 1e-3, rel=1e-12)


def test_share_of_shear_falls_with_the_square_of_the_span() -> None:
    """π² D / (S a²); an isotropic strip: π²/(5 (1 - ν)) (h/a)²."""
    laminate = Laminate([Ply(STEEL, 1e-3)])
    assert laminate.shear_share(20e-3) == pytest.approx(math.pi**2 / (5 * 0.7) / 400, rel=1e-12)
    assert laminate.shear_share(40e-3) == pytest.approx(laminate.shear_share(20e-3) / 4, rel=1e-12)


def test_thick_and_soft_laminates_are_warned_about() -> None:
    thin = Laminate([Ply(STEEL, 1e-3)])
    assert thin.shear_warning(21e-3) == ""
    assert "above 1/20" in thin.shear_warning(19e-3)
    core = Material.isotropic(E=50e6, nu=0.3, density=50)
    soft = Laminate.sandwich(Ply(STEEL, 1e-3), Ply(core, 10e-3))
    assert "soft in shear" in soft.shear_warning(0.3)  # h/a = 1/25
    assert soft.shear_warning(100.0) == ""
    hollow = Laminate([Ply(STEEL, 1e-3), Ply(STEEL, 1e-3, gap=1e-3)])
    assert hollow.shear_share(1.0) == math.inf
    assert "gives way in a gap" in hollow.shear_warning(1.0)
    for text in (thin.shear_warning(1e-3), hollow.shear_warning(1.0)):
        assert "\n" not in text


# --- layup notation --------------------------------------------------------------------------------------------------

LAYUPS: dict[str, tuple[float, ...]] = {
    "[0/90]": (0, 90),
    "[0/90]s": (0, 90, 90, 0),
    "[0/90]2s": (0, 90, 0, 90, 90, 0, 90, 0),
    "[±45]": (45, -45),
    "[±45]s": (45, -45, -45, 45),
    "[∓30/0]": (-30, 30, 0),
    "[+-30]": (30, -30),
    "[0_2/90]": (0, 0, 90),
    "[0₁₂]": (0,) * 12,
    "[(0/90)2/-45]": (0, 90, 0, 90, -45),
    "[(0/±45)_2]T": (0, 45, -45, 0, 45, -45),
    "0/-22.5/.5": (0, -22.5, 0.5),
    " [ 0° / −90 ] S ": (0, -90, -90, 0),
}


@pytest.mark.parametrize("text", LAYUPS)
def test_layup_notation_reads_as_the_books_write_it(text: str) -> None:
    assert layup_angles(text) == LAYUPS[text]
    assert [p.angle for p in Laminate.parse(text, T300, 1e-4).plies] == list(LAYUPS[text])


BAD_LAYUPS = {
    "": "at its end: there must be an angle",
    "[]": r"at '\]': there must be an angle",
    "[0/]": r"at '\]': there must be an angle",
    "[0/90": r"at its end: there must be '\]'",
    "[0/90]x": "at 'x': nothing may follow",
    "0/90s": "at 's': nothing may follow",
    "[45-]": r"at '-\]'",
    "[--45]": "there must be an angle",
    "[0_0]": "a count must be at least 1",
    "[0_]": "there must be a number of plies after '_'",
    "[0_999999999]": f"more than {MOST_PLIES} plies",
    "[(((0_99)99)99)99]": f"more than {MOST_PLIES} plies",
    "[0_9999]s": f"more than {MOST_PLIES} plies",
    "[" + "(" * 30 + "0" + ")" * 30 + "]": "brackets lie deeper than 20",
    "[1e400]": "at 'e400",
    "[" + "9" * 400 + "]": "an angle must be finite",
    "__import__('os')": "there must be an angle",
}


@pytest.mark.parametrize("text", BAD_LAYUPS)
def test_layup_that_is_none_is_refused_with_its_place(text: str) -> None:
    with pytest.raises(DesignError, match=BAD_LAYUPS[text]) as caught:
        layup_angles(text)
    assert "\n" not in str(caught.value)


def test_layup_must_be_text() -> None:
    with pytest.raises(DesignError, match=r"a layup is \[0, 90\]; it must be text"):
        layup_angles([0, 90])  # type: ignore[arg-type]


@given(st.text(alphabet="[]()/+-±∓_.0123456789sStT ₂°e\n", max_size=30) | st.text(max_size=20))
def test_any_text_is_a_layup_or_a_design_error(text: str) -> None:
    try:
        angles = layup_angles(text)
    except DesignError:
        return  # of one line, as all are
    else:
        assert 1 <= len(angles) <= MOST_PLIES
        assert all(math.isfinite(angle) for angle in angles)


@given(st.lists(st.integers(-9000, 9000).map(lambda k: k / 100), min_size=1, max_size=8), st.integers(1, 5))
def test_layup_written_out_reads_back(angles: list[float], count: int) -> None:
    text = "/".join(f"{angle:g}" for angle in angles)
    read = [float(f"{angle:g}") for angle in angles]
    assert list(layup_angles(f"[{text}]{count}")) == read * count
    assert list(layup_angles(f"[{text}]{count}s")) == read * count + (read * count)[::-1]


# --- library ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "c11", "c55", "e31"), [("PZT-5A", 61.0, 21.1, -10.4), ("PZT-5H", 60.6, 23.0, -16.6)]
)
def test_ceramics_have_the_constants_that_follow_in_print(
    name: str, c11: float, c55: float, e31: float
) -> None:
    """Erturk and Inman print in tables E.2 and E.3 what follows from table E.1 for a thin beam: moduli in GPa, and the
    stress per field of a beam that is held, E d31, C/m²."""
    ceramic = plate.material(name)
    assert pytest.approx(c11, abs=0.05) == ceramic.E1 / 1e9  # rounded in print
    assert ceramic.G13 is not None
    assert pytest.approx(c55, abs=0.05) == ceramic.G13 / 1e9
    assert ceramic.E1 * ceramic.d31 == pytest.approx(e31, abs=0.05)


def test_library_holds_what_devices_are_made_of() -> None:
    for name in ("T300/5208", "AS4/3501-6", "GY-70/934", "Scotchply 1002"):
        assert plate.material(name).E1 > plate.material(name).E2
    for name in ("T300/5208", "AS4/3501-6", "GY-70/934", "Scotchply 1002"):
        assert None not in [getattr(plate.material(name), s) for s in ("Xt", "Xc", "Yt", "Yc", "S")]
    for name in ("Kapton HN", "Mylar", "steel", "aluminium"):
        sheet = plate.material(name)
        assert sheet.E1 == sheet.E2
        assert sheet.G13 == sheet.G12


def test_paperboard_shears_as_papers_do() -> None:
    """Two rules for machine-made paper: G = 0.387 sqrt(E1 E2) (G. A. Baum, D. C. Brennan and C. C. Habeger, Tappi
    64(8), 1981), within a tenth for the papers it was found on; and that of a sheet whose shear modulus hardly depends
    on the direction, which is the sharper test of which Poisson's ratio is meant."""
    board = plate.material("paperboard")
    mean = math.sqrt(board.E1 * board.E2)
    assert pytest.approx(0.387 * mean, rel=0.1) == board.G12
    nu21 = board.nu12 * board.E2 / board.E1
    assert nu21 == pytest.approx(0.15, rel=1e-14)
    assert mean / (2 * (1 + math.sqrt(board.nu12 * nu21))) == pytest.approx(board.G12, rel=0.03)
    # The other reading of their 0.15 misses it by an eighth.
    other = mean / (2 * (1 + 0.15 * math.sqrt(board.E2 / board.E1)))
    assert other > 1.1 * board.G12
    assert board.G13 is not None
    assert board.G13 < 0.1 * board.G12  # fibres lie in the sheet
    # A card 0.4 mm thick: 312 g/m², and stiffer along than across as it feels.
    card = Laminate([Ply(board, 0.4e-3)])
    assert card.areal_mass == pytest.approx(0.312, rel=1e-12)
    assert card.D[0, 0] / card.D[1, 1] == pytest.approx(board.E1 / board.E2, rel=1e-12)


def test_film_adhesive_shears_as_its_maker_says() -> None:
    """The data sheet has a shear modulus of 60 000 psi beside E and ν, which isotropy ties together; and weights from
    0.045 to 0.085 lb/ft² at 7.5 to 13 mil, which are of one density but for thicknesses in half mils."""
    film = plate.material("AF 163-2K")
    assert pytest.approx(60_000 * 6894.757, rel=0.01) == film.G12
    for weight, mils in ((0.045, 7.5), (0.060, 9.5), (0.085, 13.0)):
        assert weight * 4.882428 / (mils * 25.4e-6) == pytest.approx(film.density, rel=0.06)


def test_every_material_of_the_library_says_where_it_is_from() -> None:
    for name, entry in plate.LIBRARY.items():
        assert entry.name == name
        assert len(entry.source) > 10
        # Positive definite in plane stress, in whatever direction.
        assert np.linalg.eigvalsh(entry.stiffness(30.0)).min() > 0.0


# --- refusals --------------------------------------------------------------------------------------------------------

BAD = {
    "fields": (
        lambda: Laminate([Ply(PZT, 1e-4)]).expansion(fields=(1.0, 2.0)),
        r"the electric field in the 1 plies of a laminate has shape \(2,\)",
    ),
    "field": (lambda: Laminate([Ply(PZT, 1e-4)]).expansion(fields=math.nan), "every number must be finite"),
    "rise": (
        lambda: Laminate([Ply(PZT, 1e-4)]).expansion(math.inf),
        "the rise in temperature of a laminate is inf",
    ),
    "gap": (
        lambda: Ply(PZT, 1e-4, gap=-1e-4),
        "the gap below a ply is -0.0001; it must be finite and at least 0",
    ),
    "lowest gap": (lambda: Laminate([Ply(PZT, 1e-4, gap=1e-4)]), "the lowest ply of a laminate has a gap"),
    "span": (
        lambda: Laminate([Ply(PZT, 1e-4)]).shear_share(0.0),
        "the span of a laminate is 0 m; it must be positive",
    ),
    "height": (lambda: Laminate.layer(PZT, 1e-4, height=math.nan), "the height of a layer is nan"),
    "face": (lambda: Laminate.sandwich([PZT], Ply(PZT, 1e-4)), "face of a sandwich holds"),  # type: ignore[list-item]
    "G23": (
        lambda: Material(1e9, 1e9, 0.3, 1e9, 1.0, G23=0.0),
        "G23 of a material is 0 Pa; a modulus must be",
    ),
    "d31": (lambda: Material(1e9, 1e9, 0.3, 1e9, 1.0, d31=math.nan), "d31 of a material is nan"),
}


@pytest.mark.parametrize("name", BAD)
def test_impossible_section_is_refused(name: str) -> None:
    make, message = BAD[name]
    with pytest.raises(DesignError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
