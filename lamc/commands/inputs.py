"""What the verbs share: the design that is named, the scene as the options change it, the folder to write to.

In: words from the command line. Out: records, or LamcErrors that name the option. Nothing in a word is ever executed:
values of effects are read as inert YAML, angles as numbers with units.
"""

import hashlib
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.places import located_at
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.times import Times
from lamc.basics.units import ANGLE, ANGLE_RATE, Quantity, to_si
from lamc.codegen.options import CompileOptions
from lamc.commands.dimensions import NONE, dimensioned
from lamc.commands.hinge_choice import AS_DRAWN, HingeChoice, stiffened
from lamc.commands.pairs import pairs_of
from lamc.commands.terminal import Progress
from lamc.design.split import split
from lamc.effects.registry import ADDED, Choice, by_name, choose
from lamc.readers.effect_calls import make_effect
from lamc.readers.inert import compose, plain
from lamc.readers.load import load, load_text
from lamc.readers.load_scene import load_scene
from lamc.records.card import NO_SHEET_OPTIONS, SheetOptions
from lamc.records.design import Design
from lamc.records.effect import Effect, hooked
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene, is_bare, is_scene_name, warn_of_degrees
from lamc.run.request import did_you_mean


@dataclass(frozen=True)
class Source:
    """Which design, and how to compile it. Exactly one of `file` and `example` is given."""

    file: str | None = None
    example: str | None = None
    compiler: str | None = None
    fast: bool = False
    precision: str = "double"
    hinges: HingeChoice = AS_DRAWN
    sheet: SheetOptions = NO_SHEET_OPTIONS
    settings: Sequence[str] = ()  # NAME=VALUE of --set

    @property
    def options(self) -> CompileOptions:
        return CompileOptions(self.compiler, self.fast, self.precision, bool(self.sheet.large))

    def check(self) -> None:
        """Raises LamcError if no design is named, or two, or a file that is none but has an example's name."""
        check_named(self.file, self.example, examples.names())


def check_named(file: str | None, example: str | None, known: Sequence[str]) -> None:
    """Raises LamcError unless either a file or an example is named, and for a missing file that an example is like."""
    if file is None and example is None:
        raise LamcError(f"name a FILE, or one of the examples with --example NAME: {', '.join(known)}")
    if file is not None and example is not None:
        raise LamcError(f"name a FILE, {file!r}, or --example {example}, not both")
    if file is not None and not os.path.exists(file):
        shipped = next((name for name in (file, Path(file).stem) if name in known), None)
        if shipped is not None:
            raise LamcError(f"{file}: there is no such file, but an example is named so: --example {shipped}")


@dataclass(frozen=True, eq=False)
class Loaded:
    """A design as read.

    origin  what to call where it comes from: its path, or the name of an example that has none
    path    its file; None for an example made to a size
    digest  SHA-256 of its bytes
    settings  values, as typed, of names that are no parameters of the design: for its run
    """

    record: Design | Mechanism
    origin: str
    path: Path | None
    digest: str
    settings: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.record.name


def load_source(
    source: Source,
    times: Times,
    progress: Progress,
    *,
    of_run: bool = False,
    more: Mapping[str, float] = NONE,
) -> Loaded:
    """Reads the design, and sets its parameters.

    of_run  names of --set that are none of the design's are left for a run
    more    further values of its parameters, SI

    Raises LamcError as `lamc.load` does, and for a name that it does not know.
    """
    source.check()
    with times.stage("load"):
        example = examples.find(source.example) if source.example is not None else None
        if example is not None and source.sheet.given:
            option = source.sheet.given[0].replace("roles", "role")
            raise LamcError(f"--{option} is of FOLD, SVG and DXF files; examples are none")
        if example is not None and example.path is None:
            digest = hashlib.sha256(example.text.encode("utf-8")).hexdigest()
            record, left = dimensioned(
                load_text(example.text, example.name), source.settings, more, of_run=of_run
            )
            record = stiffened(record, source.hinges, example.name)
            return Loaded(record, example.name, None, digest, left)
        path = example.path if example is not None else Path(source.file or "")
        assert path is not None
        sheet = source.sheet
        record = load(
            path,
            progress=lambda _name, part: progress.part(part, 1.0),
            fixed=sheet.fixed,
            card=sheet.card,
            crease=sheet.crease,
            units=sheet.units,
            roles=sheet.roles,
            heal=sheet.heal,
            facets=sheet.facets,
            large=bool(sheet.large),
        )
        record, left = dimensioned(record, source.settings, more, of_run=of_run)
        record = stiffened(record, source.hinges, str(path))
    return Loaded(record, str(path), path, hashlib.sha256(path.read_bytes()).hexdigest(), left)


def mechanism_of(loaded: Loaded, times: Times, progress: Progress) -> Mechanism:
    """The mechanism of what was read, split if it was a design."""
    if isinstance(loaded.record, Mechanism):
        return loaded.record
    with times.stage("split"):
        return split(loaded.record, lambda _name, part: progress.part(part, 1.0))


@dataclass(frozen=True)
class SceneChanges:
    """What the options change in the design's own scene: words as they were typed."""

    with_effects: Sequence[str] = ()  # NAME or NAME=VALUE
    without_effects: Sequence[str] = ()
    angles: Sequence[str] = ()  # JOINT=ANGLE
    rates: Sequence[str] = ()  # JOINT=RATE
    branch: int | None = None
    scene: str | None = None  # NAME of one of the design's, FILE, or FILE:NAME


def called_scene(mechanism: Mechanism, word: str | None) -> Scene:
    """The scene that --scene names; without it the design's own. Raises DesignError for one that is not there."""
    if word is None:
        return mechanism.scene or Scene()
    if is_scene_name(word):
        if word in mechanism.scenes:
            return mechanism.scenes[word]
        if Path(word).is_file():
            way_out = f"for the file of that name write --scene ./{word}"
        elif mechanism.scenes:
            way_out = did_you_mean(word, list(mechanism.scenes))
        else:
            way_out = (
                "the design has none with a name; name a file of scenes: --scene FILE or --scene FILE:NAME"
            )
        raise DesignError(f"--scene: no scene is named {word[:40]!r}; {way_out}")
    file, _, name = word.rpartition(":")
    if file and is_scene_name(name) and not Path(word).exists():
        return load_scene(file, name)
    return load_scene(word)


def changed_scene(mechanism: Mechanism, changes: SceneChanges) -> tuple[Scene, tuple[Choice, ...]]:
    """The scene as the options change it, with all its effects listed, and their account: in or out, and why."""
    scene = called_scene(mechanism, changes.scene)
    for name in changes.without_effects:
        _check_effect(name, "--without")
    more = tuple(_named_effect(text) for text in changes.with_effects)
    named = {effect.name for effect in more}
    for name in sorted(named & set(changes.without_effects)):
        raise DesignError(f"effect {name!r} is named by --with and by --without; keep one of them")
    left_out = tuple(dict.fromkeys(changes.without_effects))
    kept = [e for e in scene.added if e.name not in left_out and (e.name not in named or _is_repeatable(e))]
    joints = [joint.name for joint in mechanism.joints]
    changed = replace(
        scene,
        added=(*kept, *more),
        without=(*(n for n in scene.without if n not in named and n not in left_out), *left_out),
        angles=ReadOnlyDict({**scene.angles, **_quantities(changes.angles, "--angle", ANGLE, joints)}),
        rates={**scene.rates, **_quantities(changes.rates, "--rate", ANGLE_RATE, joints)},
        branch=scene.branch if changes.branch is None else changes.branch,
    )
    with located_at(scene.places):
        account = tuple(_with_options(choice, more, left_out) for choice in choose(mechanism, changed))
    effects = tuple(choice.effect for choice in account if choice.effect is not None)
    return changed.acting(effects), account


def scene_of(changes: SceneChanges) -> Callable[[Mechanism], Scene] | None:
    """What gives the scene of a mechanism that is made again and again; None: it is its own. It can be pickled."""
    return None if changes == SceneChanges() else partial(_changed, changes=changes)


def _changed(mechanism: Mechanism, changes: SceneChanges) -> Scene:
    return changed_scene(mechanism, changes)[0]


def _is_repeatable(effect: Effect) -> bool:
    return hooked(effect).repeatable


def _with_options(choice: Choice, more: Sequence[Effect], left_out: Sequence[str]) -> Choice:
    """The line of the account says which option it follows from."""
    if choice.effect is None:
        return choice._replace(reason="left out by --without") if choice.name in left_out else choice
    by_option = any(choice.effect is effect for effect in more)
    return choice._replace(reason=choice.reason.replace(ADDED, "added by --with")) if by_option else choice


def _check_effect(name: str, option: str) -> None:
    if name not in by_name():
        raise DesignError(
            f"{option}: no effect is named {name[:40]!r}; {did_you_mean(name, sorted(by_name()))}"
        )


def _named_effect(text: str) -> Effect:
    """The effect of "NAME" or "NAME=VALUE"; the value is YAML, as in a scene file."""
    name, _, value = text.partition("=")
    _check_effect(name, "--with")
    data = plain(compose(value, f"--with {name}")) if value.strip() else None
    return make_effect(name, data, f"--with {name}")


def _quantities(texts: Sequence[str], option: str, kind: Quantity, joints: Sequence[str]) -> dict[str, float]:
    """JOINT=VALUE, each with an optional unit, in SI."""
    values = {}
    for joint, value in pairs_of(texts, option, kind.example).items():
        what = f"{option} {f'{joint}={value}'!r}"
        if joint not in joints:
            raise DesignError(f"{what}: no joint is named {joint!r}; {did_you_mean(joint, joints)}")
        try:
            values[joint] = to_si(value, kind)
            if kind is ANGLE and is_bare(value):
                warn_of_degrees(values[joint], what)
        except DesignError as error:
            raise DesignError(f"{what}: {error.message}") from error
    return values


def folder_name(name: str) -> str:
    """A folder's name that resembles `name`: one path component, of letters, digits and "._-" only. A name without any
    of these is told from others by a digest."""
    found = re.sub(r"[^A-Za-z0-9._-]+", "_", name).strip("._")[:60]
    return found or f"design_{hashlib.sha256(name.encode('utf-8', 'surrogatepass')).hexdigest()[:6]}"


@contextmanager
def output_folder(out: str | None, name: str) -> Iterator[Path]:
    """The folder to write to, made if it is missing, and taken away again if nothing came to be in it.

    It is made before the work begins, so that no result is lost to a bad name. Raises LamcError for a file and for a
    place that cannot be written.
    """
    folder = Path(out) if out is not None else Path("out") / folder_name(name)
    made: list[Path] = []
    try:
        if folder.exists() and not folder.is_dir():
            raise LamcError(f"{str(folder)!r} is a file; name a folder with --out")
        made = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reported = getattr(error, "strerror", None) or error
        raise LamcError(
            f"the folder {str(folder)!r} cannot be made: {reported}; name another with --out"
        ) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise LamcError(f"the folder {str(folder)!r} cannot be written to; name another with --out")
    try:
        yield folder
    finally:
        for path in made:
            with suppress(OSError):  # not empty: it holds results
                path.rmdir()
