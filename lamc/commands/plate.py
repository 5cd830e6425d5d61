"""`lamc plate`: how a plate bends, vibrates and buckles; files, pictures and a summary.

In: a `PlateOrder`. Out: files in a folder, a summary, an exit code. Files of an earlier run that this one did not make
are taken away, so that none passes for one of this run.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.files import write_text
from lamc.basics.renewal import digests, renewed
from lamc.basics.times import Times
from lamc.basics.units import LENGTH, to_si
from lamc.commands.inputs import output_folder
from lamc.commands.plate_files import SUMMARY, own_files, write_files
from lamc.commands.plate_input import PlateSource, load_source
from lamc.commands.plate_work import answers
from lamc.commands.terminal import INTERRUPTED, Terminal, plain, problem_data
from lamc.plates.elements.description import describe
from lamc.plates.elements.library import element as element_of
from lamc.readers.plates.problem_records import PlateFile
from lamc.report.plate_data import data
from lamc.report.plate_records import PlateReport
from lamc.report.plate_text import summary

_MOST_MODES = 1000
_NOT_ALL = 3  # exit code where some cases were solved and others not


@dataclass(frozen=True)
class PlateOrder:
    """What `lamc plate` was asked for; None: as the file says."""

    source: PlateSource
    element: str | None
    size: str | None
    modes: int | None
    buckling: int | None
    cases: Sequence[str]
    solver: str
    pictures: bool
    two_meshes: bool
    out: str | None


def plate(order: PlateOrder, terminal: Terminal) -> int:
    """Solves, writes, prints; or tells what an element is, where no plate is named.

    Ctrl-C while files are written keeps those that are there. Returns 0, 130 after Ctrl-C, 3 where some cases could not
    be solved, or the exit code of what else was asked for and could not be found, after all that could.
    """
    if order.source.file is None and order.source.example is None and order.element is not None:
        text = describe(element_of(order.element))
        terminal.say(text)
        terminal.result({"ok": True, "element": order.element, "description": text})
        return 0
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        with times.stage("read"):
            file, source = load_source(order.source)
            file = _chosen(file, order)
        with output_folder(order.out, file.name) as folder:
            size = _size(order.size)
            report = answers(file, source, size, order.solver, times, two_meshes=order.two_meshes)
            with renewed(folder, SUMMARY, own_files) as staged:
                files, interrupted = [], False
                try:
                    for name in write_files(report, staged, pictures=order.pictures, progress=progress):
                        files.append(name)
                except KeyboardInterrupt:
                    interrupted = True
                summary_data = _summary(report, digests(staged, files), interrupted=interrupted)
                files = summary_data["files"]
                write_text(
                    staged / SUMMARY, json.dumps(plain(summary_data), indent=2, ensure_ascii=False) + "\n"
                )
    terminal.say(summary(report, folder, files))
    terminal.result(summary_data | {"folder": str(folder)})
    for error in report.errors:
        terminal.error(str(error))
    if interrupted:
        terminal.error(f"interrupted while files were written; see {folder}")
        return INTERRUPTED
    return max(_NOT_ALL if report.failed else 0, *(error.exit_code for error in report.errors), 0)


def _summary(report: PlateReport, sums: dict[str, str], *, interrupted: bool) -> dict[str, Any]:
    """The summary as plain data. sums: of the files that were written."""
    summary_data = data(report) | {
        "lamc_version": __version__,
        "files": [*sums, SUMMARY],
        "sha256": sums,
        "interrupted": interrupted,
    }
    if report.errors:
        summary_data["errors"] = [problem_data(error) for error in report.errors]
    return summary_data


def _chosen(file: PlateFile, order: PlateOrder) -> PlateFile:
    """The file with what options change in it. Raises LamcError for a case that it does not have."""
    unknown = [name for name in order.cases if name not in file.cases or not name]
    if unknown:
        known = ", ".join(repr(name) for name in file.cases if name) or "none"
        raise LamcError(f"--case {unknown[0]!r}: the file has no such case; it has {known}")
    for option, count in (("--modes", order.modes), ("--buckling", order.buckling)):
        if count is not None and not 0 <= count <= _MOST_MODES:
            raise LamcError(f"{option} is {count}; it must be 0 to {_MOST_MODES}")
    cases = {name: file.cases[name] for name in order.cases} if order.cases else file.cases
    return replace(
        file,
        cases=cases,
        element=order.element or file.element,
        modes=file.modes if order.modes is None else order.modes,
        buckling=file.buckling if order.buckling is None else order.buckling,
    )


def _size(text: str | None) -> float | None:
    """The length of --size, m. Raises DesignError."""
    if text is None:
        return None
    try:
        size = to_si(text, LENGTH)
    except DesignError as error:
        raise DesignError(f"--size {text!r}: {error.message}") from error
    if size <= 0.0:
        raise DesignError(f"--size {text!r}: a length of edges must be above 0")
    return size
