"""`modelDescription.xml` of FMI 2.0 and 3.0, and FMI 3.0's `buildDescription.xml`.

In: the variables of an FMU and what it is called. Out: XML as bytes. Never: a date; text from a design other than as
the value of an attribute, where XML's own writer escapes it.
"""

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from lamc.basics._version import __version__
from lamc.export.fmu_units import base_units
from lamc.export.fmu_variables import Variable

_NO_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_LOGS = {
    "logStatusError": "calls that were refused, and steps that failed",
    "logStatusDiscard": "steps that were not made to their end",
}


@dataclass(frozen=True)
class FmuFacts:
    """What the description says besides the variables."""

    title: str  # the design's name
    identifier: str  # a C name
    duration: float  # s, of the experiment that is proposed
    tolerance: float
    sources: tuple[str, ...]  # to be compiled
    token: str = ""  # by which binary and description know each other


def description_2(facts: FmuFacts, variables: Sequence[Variable]) -> bytes:
    """`modelDescription.xml` of FMI 2.0. Its indices of variables count from 1."""
    root = _root("2.0", facts, "guid")
    root.set("numberOfEventIndicators", "0")
    slave = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=facts.identifier,
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="true",
    )
    files = SubElement(slave, "SourceFiles")
    for name in facts.sources:
        SubElement(files, "File", name=name)
    _add_common(root, facts, variables)
    listing = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        scalar = SubElement(listing, "ScalarVariable", _attributes(variable, reference))
        SubElement(scalar, "Real", _real_attributes(variable, 1))
    structure = SubElement(root, "ModelStructure")
    kinds = {"Outputs": _outputs(variables), "Derivatives": _derivatives(variables)}
    for kind, references in kinds.items():
        unknowns = SubElement(structure, kind) if references else structure
        for k in references:
            behind = " ".join(str(d + 1) for d in variables[k].dependencies)
            SubElement(unknowns, "Unknown", index=str(k + 1), dependencies=behind)
    unknowns = SubElement(structure, "InitialUnknowns")
    for k in _initial_unknowns(variables):
        SubElement(unknowns, "Unknown", index=str(k + 1))
    return _written(root)


def description_3(facts: FmuFacts, variables: Sequence[Variable]) -> bytes:
    """`modelDescription.xml` of FMI 3.0."""
    root = _root("3.0", facts, "instantiationToken")
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=facts.identifier,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives="true",
        providesAdjointDerivatives="true",
        hasEventMode="false",
    )
    _add_common(root, facts, variables)
    listing = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        SubElement(listing, "Float64", _attributes(variable, reference) | _real_attributes(variable, 0))
    structure = SubElement(root, "ModelStructure")
    kinds = {"Output": _outputs(variables), "ContinuousStateDerivative": _derivatives(variables)}
    for kind, references in kinds.items():
        for k in references:
            behind = " ".join(map(str, variables[k].dependencies))
            SubElement(structure, kind, valueReference=str(k), dependencies=behind)
    for k in _initial_unknowns(variables):
        SubElement(structure, "InitialUnknown", valueReference=str(k))
    return _written(root)


def build_description(facts: FmuFacts) -> bytes:
    """`sources/buildDescription.xml` of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=facts.identifier)
    files = SubElement(build, "SourceFileSet", language="C99")
    for name in facts.sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(build, "Library", name="m", external="true", description="sin, cos and the like")
    return _written(root)


def _root(version: str, facts: FmuFacts, token: str) -> Element:
    """The outermost element; `token`: what this version calls it."""
    root = Element("fmiModelDescription", fmiVersion=version, modelName=_clean(facts.title))
    root.set(token, facts.token)
    root.set("description", "equations of motion by lamc")
    root.set("generationTool", f"lamc {__version__}")
    root.set("variableNamingConvention", "structured")
    return root


def _add_common(root: Element, facts: FmuFacts, variables: Sequence[Variable]) -> None:
    """Units, categories of the log and the experiment, which both versions have alike."""
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in variables} - {"1"}):
        element = SubElement(units, "Unit", name=unit_name(unit))
        exponents = base_units(unit)
        if exponents is not None:
            SubElement(element, "BaseUnit", {symbol: str(power) for symbol, power in exponents.items()})
        if unit in ("rad", "rad/s"):
            SubElement(
                element, "DisplayUnit", name=unit.replace("rad", "deg"), factor=repr(math.degrees(1.0))
            )
    logs = SubElement(root, "LogCategories")
    for name, meaning in _LOGS.items():
        SubElement(logs, "Category", name=name, description=meaning)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=repr(facts.duration),
        tolerance=repr(facts.tolerance),
        stepSize=repr(facts.duration / 1000),
    )


def unit_name(unit: str) -> str:
    """A unit as Modelica and most tools write it: `N·m/rad` is N.m/rad, `kg·m²` is kg.m2."""
    plain = unit.replace("·", ".").replace("*", ".").replace("^", "").replace("Ω", "Ohm")
    return _clean(plain.replace("²", "2").replace("³", "3"))


def _attributes(variable: Variable, reference: int) -> dict[str, str]:
    """Of any variable. FMI wants no `initial` of inputs and of time."""
    given = {"name": variable.name, "valueReference": str(reference)}
    given |= {"description": _clean(variable.description), "causality": variable.causality}
    given |= {"variability": variable.variability}
    if variable.causality not in ("input", "independent"):
        given["initial"] = variable.initial
    return given


def _real_attributes(variable: Variable, first: int) -> dict[str, str]:
    """Of a real variable; indices count from `first`."""
    given = {}
    if variable.unit != "1":
        given["unit"] = unit_name(variable.unit)
    start, bounds = variable.start, variable.bounds
    # The standard wants a start within the bounds.
    if start is not None and bounds.least <= start <= bounds.most:
        given |= {"min": repr(bounds.least)} if math.isfinite(bounds.least) else {}
        given |= {"max": repr(bounds.most)} if math.isfinite(bounds.most) else {}
    if start is not None:
        given["start"] = repr(float(start))
    if variable.derivative_of is not None:
        given["derivative"] = str(variable.derivative_of + first)
    return given


def _outputs(variables: Sequence[Variable]) -> list[int]:
    return [k for k, v in enumerate(variables) if v.causality == "output"]


def _derivatives(variables: Sequence[Variable]) -> list[int]:
    return [k for k, v in enumerate(variables) if v.derivative_of is not None]


def _initial_unknowns(variables: Sequence[Variable]) -> list[int]:
    """What initialisation works out: all that is calculated or starts with a guess."""
    return [k for k in _outputs(variables) if variables[k].initial in ("approx", "calculated")]


def _clean(text: str) -> str:
    """`text` on one line and without the characters that XML cannot hold."""
    return " ".join(_NO_XML.sub("?", text).split())


def _written(root: Element) -> bytes:
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
