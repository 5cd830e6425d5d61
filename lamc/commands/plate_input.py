"""What `lamc plate` is about: a plate file, an example, or a body of a design with supports and loads from options.

In: words from the command line. Out: a `PlateFile`, or LamcErrors that name the file or the option. Values of options
are read as YAML, in the language of plate files.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lamc.basics.errors import DesignError, LamcError
from lamc.commands.inputs import check_named
from lamc.commands.pairs import split_pair
from lamc.examples import plates
from lamc.readers import joints_file, popupcad
from lamc.readers.checking import did_you_mean
from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode, compose
from lamc.readers.load import file_text
from lamc.readers.native import length_unit_of
from lamc.readers.plates.problem_file import is_plate, load_plate, read_plate
from lamc.readers.plates.problem_records import PlateFile
from lamc.readers.plates.problem_schema import PLACES

_KINDS = ("plate", "design", "mechanism")
_OPTIONS = "--body, --hinges, --material, --clamp, --hinge and --load"


@dataclass(frozen=True)
class PlateSource:
    """Which plate. Exactly one of `file` and `example` is given; the rest belongs to a file that is a design.

    clamps, hinged  places: a word of `PLACES`, the name of a hinge, or YAML such as "line: [[0, 0], [0, 1]]"
    loads           PLACE=FORCE or YAML such as "pressure: 2 kPa"
    materials       NAME=MATERIAL, in place of the design's own: a name of the library, or YAML as in a plate file
    """

    file: str | None = None
    example: str | None = None
    body: Sequence[str] = ()
    hinges: str | None = None
    clamps: Sequence[str] = ()
    hinged: Sequence[str] = ()
    loads: Sequence[str] = ()
    materials: Sequence[str] = ()

    @property
    def for_designs(self) -> bool:
        """Whether an option is given that only a design takes."""
        return bool(self.body or self.hinges or self.clamps or self.hinged or self.loads or self.materials)


def load_source(source: PlateSource) -> tuple[PlateFile, str]:
    """The plate and where it comes from. Raises LamcError for neither file nor example, or both, and as readers do."""
    check_named(source.file, source.example, plates.names())
    if source.example is not None:
        path = plates.find(source.example).path
        assert path is not None
        if source.for_designs:
            raise LamcError(f"{_OPTIONS} belong to a design; an example has its own")
        return load_plate(path), str(path)
    file = source.file or ""
    root = compose(file_text(file), file)
    if not is_plate(root):
        _check_design(root)
        return read_plate(_of_design(root, file, source)), file
    if source.for_designs:
        raise LamcError(
            f"{file!r} is a plate file, which says its own supports and loads; {_OPTIONS} belong to a design"
        )
    return read_plate(root), file


def _check_design(root: Node) -> None:
    """Raises DesignError for what is neither a plate file nor like any design that lamc reads."""
    if popupcad.is_design(root) or joints_file.is_joint_definition(root):
        return
    known = "a plate file is a map with kind: plate, a laminate and a geometry; a design is a map with layers"
    if not isinstance(root, MapNode):
        found = "a list" if isinstance(root, ListNode) else "a single value"
        raise root.error(f"the file holds {found}; {known}")
    kind = root.get("kind")
    if kind is None:
        if not any(root.get(key) is not None for key in ("layers", "shapes", "materials", "joints")):
            raise root.error(f"the file has neither a kind nor layers; {known}")
    elif not isinstance(kind, ScalarNode):
        raise kind.error("kind: a word is expected here, such as plate")
    elif kind.text not in _KINDS:
        hint = did_you_mean(kind.text, _KINDS)
        raise kind.error(f"kind: {kind.text[:40]!r} is unknown; {hint}")


def _of_design(design: Node, file: str, source: PlateSource) -> Node:
    """A plate file's nodes, from a design and options."""
    if not source.body:
        raise LamcError(
            f"{file!r} is a design; say which of its bodies is the plate with --body NAME (`lamc split` lists them)"
        )
    units = "mm" if popupcad.is_design(design) else length_unit_of(design) or "m"
    body = _list([_word(name, "--body") for name in source.body])
    geometry: list[tuple[str, Node]] = [("design", _word(Path(file).name, file)), ("body", body)]
    if source.hinges is not None:
        geometry.append(("hinges", _word(source.hinges, "--hinges")))
    supports = [_map([("clamped", _place(text, "--clamp"))], f"--clamp {text!r}") for text in source.clamps]
    supports += [_map([("hinged", _place(text, "--hinge"))], f"--hinge {text!r}") for text in source.hinged]
    entries: list[tuple[str, Node]] = [
        ("kind", _word("plate", file)),
        ("name", _word(f"{Path(file).stem} {'+'.join(source.body)}", file)),
        ("units", _word(units, file)),
        ("materials", _map([_material(text) for text in source.materials])),
        ("geometry", _map(geometry, file)),
        ("supports", _list(supports)),
        ("loads", _list([_load(text) for text in source.loads])),
    ]
    return _map(entries, file)


def _material(text: str) -> tuple[str, Node]:
    name, value = split_pair(text, "--material", "'Kapton HN'")
    return name, compose(value, f"--material {text!r}")


def _place(text: str, option: str) -> Node:
    """A place: YAML as in a plate file; a word that is none of its places names a hinge."""
    node = compose(text, f"{option} {text!r}")
    if isinstance(node, ScalarNode) and node.text not in PLACES:
        return _map([("hinge", node)], node.file)
    return node


def _load(text: str) -> Node:
    """A load: YAML as in a plate file; or PLACE=FORCE, where the place is an edge or "x,y"."""
    origin = f"--load {text!r}"
    if "=" not in text:
        node = compose(text, origin)
        if not isinstance(node, MapNode):
            raise DesignError(
                f"{origin} is no load; write PLACE=FORCE, such as left='1 mN' or 10,5='2 N', or a load of a plate "
                "file, such as 'pressure: 2 kPa'"
            )
        return node
    where, _, force = text.partition("=")
    value = _word(force.strip(), origin)
    if "," in where and "{" not in where and "[" not in where:
        return _map([("point", compose(f"[{where}]", origin)), ("force", value)], origin)
    return _map([("edge", _place(where.strip(), "--load")), ("total", value)], origin)


def _word(text: str, file: str) -> ScalarNode:
    return ScalarNode("", file, 0, 0, 1, text, plain=True)


def _list(items: Sequence[Node], file: str = "") -> ListNode:
    return ListNode("", file, 0, 0, 1 + sum(item.size for item in items), tuple(items))


def _map(entries: Sequence[tuple[str, Node]], file: str = "") -> MapNode:
    size = 1 + sum(1 + node.size for _, node in entries)
    return MapNode("", file, 0, 0, size, tuple((_word(key, file), node) for key, node in entries))
