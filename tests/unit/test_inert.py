"""YAML with arbitrary tags is data and nothing else; what costs too much is refused by the limit's name."""

from pathlib import Path

import pytest

from lamc.basics.errors import DesignError, DesignErrors
from lamc.readers.inert import DEFAULT_LIMITS, Limits, ListNode, MapNode, ScalarNode, compose, plain

BOMB = "- &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"- &{chr(98 + i)} [{', '.join(['*' + chr(97 + i)] * 10)}]\n" for i in range(20)
)


def test_tags_keep_their_names_and_places() -> None:
    node = compose("a: 1\nb: !!python/object:x.y.Thing {c: !Vertex_1 [7, 2.5]}\n", "f.cad")
    assert isinstance(node, MapNode)
    thing = node.get("b")
    assert isinstance(thing, MapNode)
    assert (thing.class_name, str(thing.place)) == ("Thing", "f.cad:2:4")
    vertex = thing.get("c")
    assert isinstance(vertex, ListNode)
    assert (vertex.tag, vertex.line, vertex.column) == ("!Vertex_1", 2, 34)


def test_a_tag_that_names_a_command_runs_nothing(tmp_path: Path) -> None:
    victim = tmp_path / "ran"
    text = f"a: !!python/object/apply:os.system ['touch {victim}']\nb: !!python/name:os.system ''\n"
    assert plain(compose(text)) == {"a": [f"touch {victim}"], "b": ""}
    assert not victim.exists()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-5", 1e-5),
        ("1.0e-05", 1e-5),
        (".5", 0.5),
        ("5.", 5.0),
        ("-3", -3),
        ("no", "no"),
        ("'1'", "1"),
        ("!!str 1", "1"),
        ("true", True),
        ("~", None),
        ("1:30", "1:30"),
        ("-.inf", float("-inf")),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    result = compose(f"- {text}")
    assert isinstance(result, ListNode)
    assert isinstance(result.items[0], ScalarNode)
    assert result.items[0].value == value
    assert type(result.items[0].value) is type(value)


def test_an_alias_is_the_same_node_and_not_a_copy() -> None:
    node = compose("- &a {k: [1, 2]}\n- *a\n")
    assert isinstance(node, ListNode)
    assert node.items[0] is node.items[1]


def test_keys_may_be_objects() -> None:
    node = compose("? !M {id: 9}\n: [1]\n")
    assert isinstance(node, MapNode)
    key, value = node.pairs[0]
    assert isinstance(key, MapNode)
    assert plain(key) == {"id": 9}
    assert plain(value) == [1]


def test_exploding_aliases_are_refused_before_they_explode() -> None:
    with pytest.raises(DesignError, match="limit 'nodes'"):
        compose(BOMB, "bomb.yaml")


def test_deep_nesting_is_refused_by_its_limit() -> None:
    with pytest.raises(DesignError, match="limit 'depth' of 100"):
        compose("[" * 100_000)


def test_many_values_are_refused_by_their_limit() -> None:
    with pytest.raises(DesignError, match="limit 'nodes' of 50"):
        compose("[" + "1, " * 100 + "1]", limits=Limits(nodes=50))


def test_values_of_a_file_are_bounded_and_aliases_are_not_among_them() -> None:
    """100 000 corners are read, in some seconds; 10^6 took a minute and a half."""
    with pytest.raises(
        DesignError, match=r"f.yaml:5:7: .*limit 'values' of 10, .*fewer corners.*Limits\(values"
    ):
        compose("\n- [1, 1]" * 5, "f.yaml", limits=Limits(values=10))
    shared = "- &a [1, 1]\n" + "- *a\n" * 50
    assert compose(shared, limits=Limits(values=10)).size == 1 + 51 * 3
    assert DEFAULT_LIMITS.values > 3 * 100_000


def test_an_alias_within_its_own_anchor_is_refused() -> None:
    with pytest.raises(DesignError, match="inside its own anchor"):
        compose("a: &a [1, *a]")


def test_every_duplicate_key_is_reported_with_its_place() -> None:
    with pytest.raises(DesignErrors) as caught:
        compose("a: 1\nb: {c: 1, c: 2}\na: 3\n", "f.yaml")
    assert [str(p) for p in caught.value.problems] == [
        "f.yaml:2:11: the key 'c' stands twice in one map, first in line 2",
        "f.yaml:3:1: the key 'a' stands twice in one map, first in line 1",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a: [1",
        "a: b: c",
        "%YAML 9.9\n---\na",
        "%YAML 1.3\n---\na",
        f"%YAML 1.{'1' * 5000}\n---\na",
        '"\\UFFFFFFFF"',
        '"\\U00110000"',
        "!x!y z",
        "\x00",
        "--- a\n--- b",
        "*x",
        "\t- a",
        "'",
        "&",
        "!<",
    ],
)
def test_what_is_not_one_yaml_document_is_one_line(text: str) -> None:
    with pytest.raises(DesignError) as caught:
        compose(text, "f.yaml")
    assert str(caught.value).startswith("f.yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_reading_reports_progress_up_to_the_whole() -> None:
    reported: list[float] = []
    compose("[" + "1, " * 50_000 + "1]", progress=lambda _stage, part: reported.append(part))
    assert reported == sorted(reported)
    assert len(reported) >= 3
    assert 0.5 < reported[-1] <= 1.0
