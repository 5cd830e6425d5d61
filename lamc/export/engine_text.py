"""Text that models for other engines have in common: numbers, files of templates, tables of names.

In: numbers and names. Out: text that reads back exactly, and Markdown in which a name is a name. Never: lays out XML.
"""

import json
from collections.abc import Iterable
from xml.etree import ElementTree

from lamc.codegen.emit import environment
from lamc.export.engine_model import EngineModel
from lamc.export.markdown import markdown


def number(value: float) -> str:
    """The shortest text that reads back as `value`; no negative zero, and no exponent where none is needed."""
    text = repr(float(value) + 0.0)
    return text.removesuffix(".0")


def row(values: Iterable[float]) -> str:
    """Numbers with spaces between them."""
    return " ".join(number(value) for value in values)


def rgba(colour: str) -> str:
    """A colour such as #1f77b4 as four shares of one."""
    shares = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    return " ".join(f"{share:.3f}" for share in (*shares, 1.0))


def filled(template: str, model: EngineModel, facts: dict[str, object]) -> bytes:
    """A file of an exported model: the template's text with the model's names and `facts`."""
    renamed = [
        (kind, markdown(name), made)
        for kind, names in (("body", model.body_names), ("joint", model.joint_names))
        for name, made in names.items()
        if name != made
    ]
    context = {"design": markdown(model.mechanism.name), "model": model.name, "renamed": renamed}
    return environment().get_template(template).render(context | facts).encode()


def names_json(model: EngineModel) -> bytes:
    """The engine's names by those of the design."""
    names = {"bodies": dict(model.body_names), "joints": dict(model.joint_names)}
    return (json.dumps(names, indent=2, ensure_ascii=False) + "\n").encode()


def xml_text(root: "ElementTree.Element[str]") -> bytes:
    """The document, indented."""
    ElementTree.indent(root)
    declaration = b'<?xml version="1.0" encoding="UTF-8"?>\n'
    return declaration + ElementTree.tostring(root, encoding="unicode").encode() + b"\n"
