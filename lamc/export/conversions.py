"""`lamc.convert`: what one file holds as another format, by the suffix of the file to write.

In: a path to read, a path to write. Out: that file, and a line for each thing that it does not hold. Never: writes over
a file unasked, or leaves something out unsaid. What a format cannot hold at all, such as layers in FOLD, is refused.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from shapely.geometry import MultiPolygon

from lamc.basics.checks import shown
from lamc.basics.errors import ExportError, UnsupportedError
from lamc.basics.files import replacing
from lamc.design.linking import millimetres
from lamc.design.split import split_steps
from lamc.design.steps import SplitSteps
from lamc.export.creased import CreasedSheet
from lamc.export.cuts.creases import crease_of, lines_of_sheet, lost_in_drawing, point_of
from lamc.export.cuts.lines import CutLine, bounds_of
from lamc.export.read_back import differences, reversed_hinges
from lamc.readers.drawings.dxf_units import LARGEST, SMALLEST
from lamc.readers.joints_writer import ends, joints_text, moduli_of
from lamc.readers.mechanism_file import mechanism_text
from lamc.readers.native import Document
from lamc.readers.native_writer import design_text
from lamc.records.card import Card, Facets, SheetOptions
from lamc.records.design import Design, Layer, Material
from lamc.records.mechanism import Array, Mechanism
from lamc.records.network import listed_names
from lamc.records.scene import Scene
from lamc.report.parameters_text import parameters_line

_BENDS = "which hinges are lines along which facets bend"
_FORCE = "--force (in Python force=True)"
_CUT = "`lamc export FILE --to cut` draws each layer in a file of its own, and a .yaml file holds it all"
_LAYERS = "SVG and DXF hold those, in a drawing and a design that takes its shapes from it"


@dataclass(frozen=True)
class Converted:
    """content: of the file; lost: what it does not hold, in words; again: options that read it back; same: whether it
    is the same device then, None where it was not read back; design: the text of a native design that takes its shapes
    from the file."""

    content: bytes
    lost: tuple[str, ...] = ()
    again: str = ""
    same: bool | None = None
    design: str | None = None


Maker: TypeAlias = Callable[[Design | Mechanism, str], Converted]  # of a record, and the name of the file


def check_place(source: Path, target: Path, *, force: bool) -> None:
    """Raises ExportError for a suffix that means nothing, for the file that is read, and for one that is there, unless
    forced."""
    _maker(target)
    _check_not_read(source, target)
    _check_free(target, force=force)


def _check_not_read(source: Path, target: Path) -> None:
    if _is_there(target) and source.exists() and target.exists() and os.path.samefile(source, target):
        raise ExportError(f"{str(target)!r} is the file that is read; name another")


def _check_free(target: Path, *, force: bool) -> None:
    is_there = _is_there(target)
    if is_there and target.is_dir():
        raise ExportError(f"{str(target)!r} is a folder; name a file in it")
    if is_there and not force:
        raise ExportError(f"{str(target)!r} is there; name another file, or replace it with {_FORCE}")


def _is_there(target: Path) -> bool:
    try:
        target.lstat()
    except FileNotFoundError:
        return False
    except OSError as error:
        raise ExportError(
            f"{shown(str(target))} cannot be written: {error.strerror}; name another"
        ) from error
    return True


def design_beside(path: Path) -> Path:
    """Of the design that takes its shapes from a drawing."""
    return path.with_name(f"{path.name}.yaml")


def write(made: Converted, path: Path, *, force: bool) -> None:
    """Each file in one step. Raises ExportError where a design is in the way of the one beside a drawing, unless
    forced, and LamcError where a file cannot be written."""
    if made.design is None:
        with replacing(path) as temporary:
            temporary.write_bytes(made.content)
        return
    beside = design_beside(path)
    _check_free(beside, force=force)
    # Both are written before either has its name.
    with replacing(beside) as design, replacing(path) as temporary:
        temporary.write_bytes(made.content)
        design.write_text(made.design, encoding="utf-8", newline="\n")


def converted(record: Design | Mechanism, path: Path, source: Path) -> Converted:
    """The content of the file. Raises ExportError for its suffix, and where it would replace what the record was read
    from; UnsupportedError for what it cannot hold.

    source  the file that the record was read from"""
    if isinstance(record, Design):
        for name, _ in record.beside:
            _check_not_read(source.parent / name, path)
    made = _maker(path)(record, path.name)
    if made.design is not None:
        _check_not_read(source, design_beside(path))
    if record.origin is not None and isinstance(record.origin.recipe, Document):
        said = f"parameters, whose values are written in: {parameters_line(record.parameters)}"
        made = replace(made, lost=(said, *made.lost))
    if source.suffix.lower() == ".joints":  # the record is a mechanism
        return replace(made, lost=("layers and materials, and where hinge lines end", *made.lost))
    return made


def _maker(path: Path) -> Maker:
    name = path.name.lower()
    for suffix, maker in FORMATS.items():
        if name.endswith(suffix):
            return maker
    raise ExportError(
        f"the file to write is {shown(path.name)}; its suffix must be one of {', '.join(FORMATS)}"
    )


# --- formats ------------------------------------------------------------------------------------------------------


def _native(record: Design | Mechanism, file: str) -> Converted:
    if isinstance(record, Mechanism):
        return _mechanism(record, file)
    lost = [f"what the file was without: {note}" for note in record.notes]
    return Converted(design_text(record).encode(), tuple(lost))


def _mechanism(record: Design | Mechanism, file: str) -> Converted:
    lost = []
    if isinstance(record, Design):
        lost = ["layers and materials, and lines and gaps of hinges, for effects that bend what is drawn"]
        record = split_steps(record).mechanism
    if record.facet_creases:
        lost.append(_BENDS)
    return Converted(mechanism_text(record).encode(), tuple(lost))


def _joints(record: Design | Mechanism, file: str) -> Converted:
    lost = []
    if isinstance(record, Design):
        steps = split_steps(record)
        made, layers = steps.mechanism, record.layers
        lines = {c.hinge.name: ends(c.hinge.line.coords) for c in steps.connections}
        lost = _lost_of_design(steps)
    else:
        sheet = CreasedSheet(record, "a joint definition holds layers, or a sheet of")
        _check_sheet(sheet, "a joint definition holds layers, or a sheet of one card")
        assert sheet.card is not None
        made, layers, lines = record, (_card_layer(sheet.card),), {}
        if record.facet_creases:
            lost.append(_BENDS)
    lost += _lost_of_scenes(made, angles=False) + _lost_words(made, file)
    return Converted(joints_text(made, layers, lines).encode(), tuple(lost))


def _lost_of_design(steps: SplitSteps) -> list[str]:
    lost = ["hinges' gaps, names of layers, and material that no body has"]
    partly = [
        layer.name
        for layer in steps.design.layers
        if moduli_of(layer.material) is None
        and (layer.material.E1, layer.material.E2, layer.material.poisson) != (None, None, None)
    ]
    if partly:
        lost.append(f"moduli of layers of which not all are known: {listed_names(partly)}")
    if any(layer.angle for layer in steps.design.layers):
        lost.append("ply angles")
    if any(layer.material.G12 is not None for layer in steps.design.layers):
        lost.append("shear moduli")
    if steps.mechanism.facet_creases:
        lost.append(_BENDS)
    return lost


def _card_layer(card: Card) -> Layer:
    return Layer("card", Material("card", card.density, is_rigid=True), card.thickness, MultiPolygon())


def _fold(record: Design | Mechanism, file: str) -> Converted:
    from lamc.export.fold import flat_bytes

    if isinstance(record, Design):
        raise UnsupportedError(f"FOLD holds a sheet of creases, and {record.name!r} has layers; {_LAYERS}")
    sheet = CreasedSheet(record, "FOLD holds")
    _check_sheet(sheet, "FOLD holds a sheet of one card")
    lost = list(sheet.lost)
    if sheet.windows:
        lost.append(f"windows in facets ({len(sheet.windows)}), whose card is weighed")
    if record.facet_creases:
        lost.append(_BENDS)
    lost += _lost_of_scenes(record, angles=True) + ([] if not record.story else ["its story"])
    content = flat_bytes(record)
    return Converted(content, (*lost, *_lost_points(record), *reversed_hinges(record, content)))


def _drawing(kind: str, write: Callable[[list[CutLine], str], bytes], *, paged: bool) -> Maker:
    """paged: places count from the upper left corner of a page, as in SVG."""

    def maker(record: Design | Mechanism, file: str) -> Converted:
        if isinstance(record, Design):
            return _laminate(record, file, write, paged=paged)
        sheet = CreasedSheet(record, f"{kind} holds")
        _check_sheet(sheet, f"{kind} holds a sheet of one card")
        lines = lines_of_sheet(sheet)
        low, high = bounds_of(lines)
        corner = np.array([low[0], high[1]]) if paged else np.zeros(2)
        content, options = write(lines, record.name), _options(sheet, corner)
        if kind == "DXF" and not SMALLEST <= max(high - low) <= LARGEST:
            options = replace(options, units="mm")  # what the file says, and would be asked about
        unlike = differences(record, content, f".{kind.lower()}", options, corner)
        # An SVG's title is its name.
        lost = sheet.lost + lost_in_drawing(sheet, lines) + unlike
        lost += _lost_scenes(record) + _lost_words(record, record.name if paged else file)
        if corner.any():
            lost.append(
                f"where it lies: its page begins at {millimetres((float(corner[0]), float(corner[1])))}"
            )
        same = not (unlike or sheet.lost)
        return Converted(content, tuple(lost), _words(options), same=same)

    return maker


def _laminate(
    design: Design, file: str, write: Callable[[list[CutLine], str], bytes], *, paged: bool
) -> Converted:
    """Raises UnsupportedError where lamc would not read the two files as the same design."""
    from lamc.export.laminate_drawing import manifest_of, misreadings

    unlike: list[str] = []
    for parted in (False, True):
        manifest = manifest_of(design, file, paged=paged, parted=parted)
        content = write(list(manifest.lines), design.name)
        unlike = misreadings(design, manifest, content, file)
        if not unlike:
            lost = [f"what the file was without: {note}" for note in design.notes]
            return Converted(content, tuple(lost), same=True, design=manifest.text)
    raise UnsupportedError(
        f"{shown(file)} would not be read as the device that is drawn: {'; '.join(unlike)}; {_CUT}"
    )


def _options(sheet: CreasedSheet, corner: Array) -> SheetOptions:
    """What the drawing does not say; its places count from a corner, m. Its lines meet: healing would close slivers."""
    x, y = (point_of(sheet) - corner).tolist()
    facets: Facets = "bend" if sheet.mechanism.facet_creases else "rigid"
    return SheetOptions(fixed=(x, y), card=sheet.card, crease=crease_of(sheet), facets=facets, heal=0.0)


def _words(options: SheetOptions) -> str:
    """As the command line takes them."""
    words = []
    if options.card is not None:
        words.append(f"--card '{options.card.thickness!r} m, {options.card.density!r} kg/m^3'")
    if options.crease is not None:
        words.append(f"--crease {options.crease!r}")
    words += [f"--fixed '{each[0]!r}, {each[1]!r}'" for each in options.held]
    words += [f"--units {options.units}"] if options.units is not None else []
    return " ".join([*words, f"--facets {options.facets}", "--heal 0"])


def _svg(lines: list[CutLine], name: str) -> bytes:
    from lamc.export.cuts.svg import svg_text

    return svg_text(lines, name).encode()


def _dxf(lines: list[CutLine], name: str) -> bytes:
    from lamc.export.cuts.dxf import dxf_bytes

    return dxf_bytes(lines)


FORMATS: Mapping[str, Maker] = MappingProxyType(
    {
        ".mechanism.yaml": _mechanism,
        ".mechanism.yml": _mechanism,
        ".yaml": _native,
        ".yml": _native,
        ".joints": _joints,
        ".fold": _fold,
        ".svg": _drawing("SVG", _svg, paged=True),
        ".dxf": _drawing("DXF", _dxf, paged=False),
    }
)


# --- what is lost -------------------------------------------------------------------------------------------------


def _check_sheet(sheet: CreasedSheet, what: str) -> None:
    """Raises UnsupportedError for a mechanism that is no sheet."""
    if sheet.faults:
        raise UnsupportedError(f"{what}; {sheet.mechanism.name!r} has {'; '.join(sheet.faults)}")


def _lost_of_scenes(mechanism: Mechanism, *, angles: bool) -> list[str]:
    """angles: whether the format holds where a sheet starts."""
    lost = []
    scene = mechanism.scene
    if scene is not None and scene != (Scene(angles=scene.angles) if angles else Scene()):
        lost.append("its scene" if not angles else "its scene but for the angles at which it starts")
    return lost + _lost_scenes(mechanism)


def _lost_scenes(mechanism: Mechanism) -> list[str]:
    return [f"its scenes ({', '.join(mechanism.scenes)})"] if mechanism.scenes else []


def _lost_words(mechanism: Mechanism, file: str) -> list[str]:
    """file: whose name, without its suffix, is the device's."""
    lost = [] if mechanism.name == file.partition(".")[0] else [f"its name, {mechanism.name!r}"]
    return lost + (["its story"] if mechanism.story else []) + _lost_points(mechanism)


def _lost_points(mechanism: Mechanism) -> list[str]:
    return ["contact points"] if mechanism.contact_points else []
