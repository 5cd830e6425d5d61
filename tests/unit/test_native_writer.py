"""Designs as native text: what is written reads back equal, to the last bit."""

import warnings
from dataclasses import replace
from pathlib import Path

import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import MultiPolygon, Point

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, Place
from lamc.readers.load import load_text
from lamc.readers.native_writer import design_text, write_design
from lamc.records.design import BodyName, Design, FacetCreases, HingeLine, HingeSet, Layer, Material, Places

BOARD = Material("board", 1800.0, 70e9, 70e9, 0.3, is_rigid=True)
FILM = Material("film", 1420.0, 2.5e9, 2.6e9, 0.34, is_flexible=True, G12=1e9)


def bare(design: Design) -> Design:
    """Without its file's name and lines, and with polygons in shapely's normal form: a union orders them anew."""
    return replace(
        design,
        source="",
        places=Places(),
        layers=tuple(replace(each, geometry=shapely.normalize(each.geometry)) for each in design.layers),
        fixed=tuple(shapely.normalize(each) for each in design.fixed),
        hinges=tuple(
            replace(each, lines=tuple(replace(line, place=Place()) for line in each.lines))
            for each in design.hinges
        ),
    )


def back(design: Design) -> Design:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*the hinge bends in layer")  # so of the design too, and no loss
        made = load_text(design_text(design), "back.yaml")
    assert isinstance(made, Design)
    return made


def designs() -> list[str]:
    return [name for name in examples.names() if isinstance(loaded(name), Design)]


def loaded(name: str) -> Design | lamc.Mechanism:
    example = examples.find(name)
    return lamc.load(example.path) if example.path is not None else load_text(example.text, name)


@pytest.mark.parametrize("name", designs())
@pytest.mark.quick("pendulum", "four_bar", "folding_box", "yoshimura", "crawler")
def test_every_example_reads_back_equal(name: str) -> None:
    design = loaded(name)
    assert isinstance(design, Design)
    assert bare(back(design)) == bare(design)
    mechanism, same = lamc.split(design), lamc.split(back(design))
    assert same == mechanism
    assert design_text(back(design)) == design_text(design)


def test_a_popupcad_file_becomes_a_native_one(tmp_path: Path) -> None:
    cad = Path(examples.__file__).parent / "pendulum.cad"
    design = lamc.load(cad)
    assert isinstance(design, Design)
    write_design(design, tmp_path / "pendulum.yaml")
    made = lamc.load(tmp_path / "pendulum.yaml")
    assert isinstance(made, Design)
    assert lamc.split(made) == lamc.split(design)


number = st.floats(-1.0, 1.0, allow_nan=False).map(lambda x: round(x, 17))
positive = st.floats(1e-6, 1.0)
maybe = st.none() | positive
words = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=12).filter(
    lambda word: word.strip() and word.isprintable() and word != "all"
)


@st.composite
def boxes(draw: st.DrawFn) -> MultiPolygon:
    """Up to three boxes apart, some with windows."""
    parts = []
    for k in range(draw(st.integers(1, 3))):
        x, y, w, h = 3.0 * k + draw(number), draw(number), draw(positive), draw(positive)
        part = shapely.box(x, y, x + w, y + h)
        if draw(st.booleans()) and w > 1e-3 and h > 1e-3:
            part = part.difference(shapely.box(x + 0.25 * w, y + 0.25 * h, x + 0.5 * w, y + 0.5 * h))
        parts.append(part)
    return MultiPolygon(parts)


@st.composite
def drawn(draw: st.DrawFn) -> Design:
    names = draw(st.lists(words, min_size=1, max_size=3, unique=True))
    shapes = [draw(boxes()) for _ in names]
    if draw(st.booleans()):
        shapes = [shapes[0]] * len(names)
    materials = [draw(st.sampled_from([BOARD, FILM])) for _ in names]
    layers = tuple(
        Layer(name, material, draw(positive) * 1e-3, shape, draw(number))
        for name, material, shape in zip(names, materials, shapes, strict=True)
    )
    through = st.sets(st.integers(0, len(names) - 1), min_size=1).map(lambda found: tuple(sorted(found)))
    line_names = draw(st.lists(words, max_size=4, unique=True))
    hinges = tuple(
        HingeSet(
            tuple(
                HingeLine(((0.0, draw(number)), (1.0 + draw(positive), draw(number))), name) for name in own
            ),
            draw(positive),
            draw(st.integers(0, len(names) - 1)),
            draw(through),
            draw(st.just(0.0) | positive),
            draw(st.just(0.0) | positive),
            draw(st.floats(-9.0, 9.0)),
            draw(st.sampled_from([(-0.5, 0.25), (-7.0, 8.0), lamc.records.mechanism.FREE_LIMITS])),
        )
        for own in ([(name,) for name in line_names] + [(None, None)])
    )
    return Design(
        draw(words),
        layers,
        hinges,
        tuple(draw(st.sampled_from([MultiPolygon(), shapes[0]])) for _ in names),
        tuple(
            BodyName(
                name, Point(draw(number), draw(number)), draw(st.none() | st.integers(0, len(names) - 1))
            )
            for name in draw(st.lists(words, max_size=2, unique=True))
        ),
        story=draw(st.text(max_size=40)).strip(),
        contact_points=tuple(draw(st.lists(st.tuples(number, number), max_size=2))),
        facet_creases=draw(st.none() | st.builds(FacetCreases, maybe, positive)),
    )


@pytest.mark.slow
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
@given(drawn())
def test_any_design_reads_back_equal(design: Design) -> None:
    assert bare(back(design)) == bare(design)


def test_numbered_lines_stay_one_entry_and_others_part() -> None:
    layer = Layer("film", FILM, 1e-4, MultiPolygon([shapely.box(0, 0, 1, 1)]))
    lines = [
        HingeLine(((0.1 * k, 0.0), (0.1 * k, 1.0)), name) for k, name in enumerate(("a_1", "a_2", "b"), 1)
    ]

    def entries(own: list[HingeLine]) -> int:
        return len(
            back(Design("d", (layer,), (HingeSet(tuple(own), 1e-3, 0, (0,)),), (layer.geometry,))).hinges
        )

    assert entries(lines[:2]) == 1
    assert entries(lines) == 3


def test_two_materials_of_one_name_are_numbered() -> None:
    other = replace(BOARD, density=900.0)
    sheet = MultiPolygon([shapely.box(0, 0, 1, 1)])
    layers = tuple(Layer(f"l{k}", m, 1e-4, sheet) for k, m in enumerate((BOARD, other, BOARD)))
    made = back(Design("d", layers, (), (sheet,) * 3))
    assert [each.material.name for each in made.layers] == ["board", "board_2", "board"]
    assert [each.material.density for each in made.layers] == [1800.0, 900.0, 1800.0]


def test_a_layer_named_all_cannot_be_written() -> None:
    layer = Layer("all", FILM, 1e-4, MultiPolygon([shapely.box(0, 0, 1, 1)]))
    with pytest.raises(DesignError, match="rename it"):
        design_text(Design("d", (layer,), (), (layer.geometry,)))
