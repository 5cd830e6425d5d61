"""`load`: a file becomes a `Design` or a `Mechanism`, whichever of lamc's formats it holds.

In: a path, or a text. Out: a record. The content decides which format it is, not the suffix. Nothing in a file is ever
executed, and every failure is a LamcError with the place.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, LamcError, Place, UnsupportedError, warn
from lamc.basics.files import read_bytes
from lamc.readers import joints_file, popupcad
from lamc.readers.drawings.reading import check_meant, drawing_in, is_drawing
from lamc.readers.fold import read_fold
from lamc.readers.fold_file import is_fold
from lamc.readers.inert import (
    DEFAULT_LIMITS,
    STANDARD_TAGS,
    Limits,
    ListNode,
    MapNode,
    Node,
    Progress,
    ScalarNode,
    compose,
)
from lamc.readers.joint_definition import JointDefinition
from lamc.readers.mechanism_file import read_mechanism
from lamc.readers.native import read_design
from lamc.readers.popupcad_beside import Beside
from lamc.records.card import NO_SHEET_OPTIONS, Card, Facets, Fixed, SheetOptions
from lamc.records.design import Design, Material
from lamc.records.drawing import Role
from lamc.records.mechanism import Mechanism

_NO_YAML = (is_fold,)  # tell formats whose text is none of YAML; each is read in `_read`
FORMATS = (
    "a lamc design or mechanism, FOLD, SVG, DXF, a popupCAD design (.cad) or a popupCAD joint definition "
    "(.joints)"
)


def load(
    path: Path | str,
    *,
    materials: Mapping[str, Material] | None = None,
    progress: Progress | None = None,
    limits: Limits = DEFAULT_LIMITS,
    fixed: Fixed | Sequence[Fixed] | None = None,
    card: Card | None = None,
    crease: float | str | None = None,
    units: str | None = None,
    roles: Mapping[str, Role] | None = None,
    layers: Mapping[str, str] | None = None,
    heal: float | str | None = None,
    facets: Facets | None = None,
    large: bool = False,
    set: Mapping[str, float | str] | None = None,  # noqa: A002  what the command line calls --set
) -> Design | Mechanism:
    """The design or mechanism in the file at `path`.

    materials  replace a popupCAD file's materials of the same name, whose moduli are often placeholders
    progress   called now and then with a stage's name and the fraction of it that is done
    limits     what the file may cost; a file beyond them is refused with the limit's name
    fixed, card, crease, units, roles, heal, facets  of a sheet of creases: see `SheetOptions`; None: what the file
               says, else a default with a warning
    layers     roles of a drawing's layers, by any name that layers are known by: "outline" is border
    large      a sheet may have more facets than take some seconds
    set        values of its `parameters` in the place of their defaults, SI or text: {"length": "50 mm"}

    Raises DesignError (DesignErrors for several problems) for a file that is missing, unreadable, malformed
    or impossible, and UnsupportedError for one that is well formed and beyond this version.
    """
    if not isinstance(path, str | os.PathLike):
        raise DesignError(f"the path is {shown(path)}; it must be a string or a pathlib.Path")
    if materials is not None and not isinstance(materials, Mapping):
        raise DesignError(f"materials is {shown(materials)}; it must map names to Material records")
    record = _loaded(
        Path(path),
        materials,
        progress,
        limits,
        SheetOptions(fixed, card, crease, units, _with_layers(roles, layers), heal, facets, large),
    )
    return record if set is None else record.with_parameters(set)


def _with_layers(
    roles: Mapping[str, Role] | None, layers: Mapping[str, str] | None
) -> Mapping[str, Role] | None:
    """Roles, and those of layers, which a name such as "outline" says too."""
    if layers is None or not (roles is None or isinstance(roles, Mapping)):  # refused by SheetOptions
        return roles
    if not isinstance(layers, Mapping):
        raise DesignError(f"layers is {shown(layers)}; it must map layers to what they are for")
    from lamc.readers.drawings.roles import layer_role

    both = set(layers) & set(roles or {})
    if both:
        raise DesignError(f"roles and layers both say what {shown(min(both, key=str))} is for; leave one out")
    # What is no role is told by SheetOptions.
    known = {n: (layer_role(role) if isinstance(role, str) else None) or role for n, role in layers.items()}
    return {**(roles or {}), **cast(Mapping[str, Role], known)}


def _loaded(
    path: Path,
    materials: Mapping[str, Material] | None,
    progress: Progress | None,
    limits: Limits,
    sheet: SheetOptions,
) -> Design | Mechanism:
    beside = Beside(path, limits, _text)
    data, file = read_bytes(path, limits.bytes), str(path)
    drawing = drawing_in(data, file, sheet, limits, progress)
    if drawing is None:
        return _read(_text(data, file), file, materials or {}, progress, limits, beside, sheet)
    if materials:
        raise DesignError("materials are of popupCAD designs; a drawing takes card=", Place(file))
    from lamc.readers.drawings.sheet import sheet_of  # other files do without healing

    try:
        return sheet_of(drawing, sheet)
    except LamcError:
        for note in drawing.notes:  # what was left out may be why
            warn(note, Place(file))
        raise


def load_text(
    text: str, name: str, *, limits: Limits = DEFAULT_LIMITS, drawings: Mapping[str, bytes] | None = None
) -> Design | Mechanism:
    """The design or mechanism in a text that is in no file; messages call it `name`. Raises as `load` does.

    drawings  that it takes shapes from, by the names that it has for them"""
    return _read(text, name, {}, None, limits, Beside(limits=limits, given=drawings or {}))


def load_definition(path: Path | str, *, limits: Limits = DEFAULT_LIMITS) -> JointDefinition | None:
    """The joint definition in the file at `path`, layers and drawn lines included; None for another format.

    For a file that `load` has read. Raises DesignError as `load` does.
    """
    data = read_bytes(Path(path), limits.bytes)
    if is_drawing(data):
        return None
    text = _text(data, str(path))
    if any(told(text) for told in _NO_YAML):
        return None
    node = compose(text, str(path), limits=limits)
    return joints_file.read_definition(node) if joints_file.is_joint_definition(node) else None


def file_text(path: Path | str, limits: Limits = DEFAULT_LIMITS) -> str:
    """The text of a file. Raises DesignError where there is none, or what it holds is no text, or a drawing."""
    data = read_bytes(Path(path), limits.bytes)
    if is_drawing(data):
        raise DesignError(
            "the file is a drawing, which is read as a sheet of creases (lamc run, split, …); here YAML is read",
            Place(str(path)),
        )
    return _text(data, str(path))


def _read(
    text: str,
    file: str,
    materials: Mapping[str, Material],
    progress: Progress | None,
    limits: Limits,
    beside: Beside,
    sheet: SheetOptions = NO_SHEET_OPTIONS,
) -> Design | Mechanism:
    try:
        if is_fold(text):
            if materials:
                raise DesignError("materials are of popupCAD designs; a FOLD file takes card=", Place(file))
            if sheet.roles is not None:
                raise DesignError(
                    "roles is for drawings; a FOLD file says itself what its edges are", Place(file)
                )
            return read_fold(text, file, sheet, limits)
        if sheet.given:
            check_meant(text, file, sheet, limits)
            raise DesignError(
                f"{sheet.given[0]} is for sheets (FOLD, SVG, DXF); edit this file instead", Place(file)
            )
        node = compose(text, file, limits=limits, progress=progress)
        return _record(node, materials, progress, beside)
    except LamcError:
        raise
    except RecursionError as error:
        raise DesignError("the file nests too deeply to be read", Place(file)) from error


def _record(
    node: Node, materials: Mapping[str, Material], progress: Progress | None, beside: Beside
) -> Design | Mechanism:
    if progress is not None:
        progress("checking", 0.0)
    record: Design | Mechanism
    if popupcad.is_design(node):
        record = popupcad.read_design(node, materials, beside)
    elif materials:
        raise DesignError(
            "materials can be replaced in popupCAD designs only; edit this file instead", node.place
        )
    elif joints_file.is_joint_definition(node):
        record = joints_file.read_joints(node)
    else:
        record = _native(node, beside)
    if progress is not None:
        progress("checking", 1.0)
    return record


def _native(node: Node, beside: Beside) -> Design | Mechanism:
    if node.tag not in STANDARD_TAGS:
        raise UnsupportedError(f"the file holds a {node.class_name[:60]!r}; lamc reads {FORMATS}", node.place)
    if not isinstance(node, MapNode):
        found = "a list" if isinstance(node, ListNode) else "a single value"
        raise DesignError(f"the file holds {found}; lamc reads {FORMATS}", node.place)
    kind_node = node.get("kind")
    kind: str | None = kind_node.text if isinstance(kind_node, ScalarNode) else None
    if kind_node is None:
        kind = "mechanism" if node.get("joints") is not None and node.get("layers") is None else "design"
        if not any(node.get(key) is not None for key in ("layers", "shapes", "materials", "joints")):
            if any(node.get(key) is not None for key in ("scene", "scenes", "effects", "angles")):
                raise _scenes_alone(node)
            raise DesignError(f"the file has neither layers nor joints; lamc reads {FORMATS}", node.place)
    if kind == "design":
        return read_design(node, beside)
    if kind == "mechanism":
        return read_mechanism(node)
    assert kind_node is not None
    if kind == "scene":
        raise _scenes_alone(node)
    if kind == "plate":
        raise DesignError(
            "the file holds a plate problem, not a design; `lamc plate` solves it", kind_node.place
        )
    if kind == "study":
        raise DesignError(
            "the file holds a study, not a design; `lamc sweep` runs it, and `lamc optimise`", kind_node.place
        )
    shown = repr(kind[:40]) if kind is not None else "this"
    raise DesignError(f"kind: {shown} is unknown; it is 'design' or 'mechanism'", kind_node.place)


def _scenes_alone(node: Node) -> DesignError:
    return DesignError(
        "the file holds scenes, not a design; name it beside one: lamc run DESIGN --scene FILE", node.place
    )


def _text(data: bytes, file: str) -> str:
    """The bytes as text. Raises DesignError for what is not text, or holds nothing."""
    if not data.strip():
        raise DesignError(f"the file is empty; lamc reads {FORMATS}", Place(file))
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise DesignError(
            f"byte {error.start} ({data[error.start]:#04x}) is not UTF-8: if it is text, save it as UTF-8 in your "
            f"editor; lamc reads {FORMATS}",
            Place(file, line),
        ) from error
    return text
