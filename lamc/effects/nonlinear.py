"""Hinges whose restoring torque is no straight line: polynomials, expressions, and measured tables."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field, PlainValidator, ValidationInfo, WithJsonSchema

from lamc.basics.checks import checked_name, is_list, shown
from lamc.basics.errors import DesignError
from lamc.basics.fields import EXPRESSIONS, FOLDER, part
from lamc.basics.number_text import is_measured
from lamc.basics.quantity_fields import Expressions, Unit
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.hinges import stiffness_claim
from lamc.effects.registered import RegisteredEffect
from lamc.effects.table_file import MAX_ROWS
from lamc.effects.torque_laws import BETWEEN, MAX_DEGREE, LawData, law_of
from lamc.mechanics.loads import Loads
from lamc.symbolic.scalars import Value

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

_NUMBER = {"type": ["number", "string"], "description": "a number (SI), or text with a unit"}
LAW_SCHEMA: Mapping[str, Any] = {
    "anyOf": [
        {
            "type": "string",
            "description": "torque, N*m, as an expression in angle; or a stiffness with its unit",
        },
        {"type": "array", "items": _NUMBER, "minItems": 1, "maxItems": MAX_DEGREE},
        {
            "type": "object",
            "properties": {
                "table": {
                    "type": "array",
                    "items": {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2},
                    "minItems": 2,
                    "maxItems": MAX_ROWS,
                },
                "file": {"type": "string", "description": "a CSV file of angle and torque"},
                "between": {"enum": [*BETWEEN]},
                "located": {"type": "boolean"},
                "energy": {"type": "string", "description": "energy, J, as an expression in angle"},
            },
            "additionalProperties": False,
        },
    ]
}


def _laws(laws: Any, info: ValidationInfo) -> ReadOnlyDict[str, LawData]:
    """The laws in their canonical form; coefficients and tables may have units."""
    with part():
        if not isinstance(laws, Mapping):
            raise DesignError(
                f"nonlinear_stiffness is {shown(laws)}; give a law for each joint, such as {{h1: [0.1, 0, 0.3]}}"
            )
    context = info.context or {}
    found: dict[str, LawData] = {}
    for joint, data in sorted(laws.items(), key=lambda item: str(item[0])):
        with part():
            checked_name(joint, "the joint of a nonlinear stiffness")
        plain = _plain(data, joint, context)
        with part(joint):
            found[joint] = law_of(plain, f"the stiffness of hinge {joint!r}", context.get(FOLDER)).data
    return ReadOnlyDict(found)


def _plain(data: object, joint: str, context: Mapping[str, Any]) -> object:
    """The law with quantities in SI, and expressions with values for parameters of the file."""
    expressions: Expressions | None = context.get(EXPRESSIONS)

    def quantity(value: object, unit: str, *path: str | int) -> float:
        with part(*path):
            return Unit(unit).number(value, {"rad": "angle", "N*m": "torque"}.get(unit, "stiffness"), context)

    def torque(text: str) -> object:
        drive = text if expressions is None else expressions.in_drive(text)
        return (quantity(text, "N*m/rad", joint),) if is_measured(text) or drive is None else drive

    if isinstance(data, str):
        return torque(data)
    if isinstance(data, list | tuple):
        return tuple(
            quantity(value, "N*m/rad" if power == 1 else f"N*m/rad^{power}", joint, power - 1)
            for power, value in enumerate(data, start=1)
        )
    if isinstance(data, Mapping) and isinstance(data.get("table"), list | tuple):
        rows = []
        for k, row in enumerate(data["table"]):
            with part(joint, "table", k):
                if not is_list(row) or len(row) != 2:
                    raise DesignError(f"the row is {shown(row)}; give [angle, torque]")
            path = (joint, "table", k)
            rows.append((quantity(row[0], "rad", *path, 0), quantity(row[1], "N*m", *path, 1)))
        return {**data, "table": tuple(rows)}
    if isinstance(data, Mapping) and isinstance(data.get("energy"), str) and expressions is not None:
        return {**data, "energy": expressions.in_drive(data["energy"]) or data["energy"]}
    return data


@dataclass(frozen=True)
class NonlinearStiffness(RegisteredEffect):
    """Restoring torques T(angle) by joint name; the hinge feels -T, and stores ∫ T from its rest angle on.

    The angle, rad, counts from the joint's rest angle, whether RestAngle acts or not. The law takes the place of the
    linear spring: HingeStiffness and RestAngle leave these hinges out. A law is one of

        [0.1, 0.0, 0.3]                          T = 0.1 angle + 0.3 angle³, N·m/rad, N·m/rad², …: parameters
        "0.1*angle + 0.3*sinh(angle)"            T, N·m, as an expression in angle
        {"energy": "0.05*angle^2"}               W, J, as an expression; T is its derivative
        {"table": [(-1, -2), (0, 0), (1, 3)]}    points (rad, N·m), 2 to 10 000, angles ascending
        {"file": "hinge.csv"}                    the same from a file, which is read once, when the record is made

    Tables are joined by a natural cubic spline ("between": "spline"), which is twice smooth, or with "monotone" by a
    curve that does not overshoot, but is only once smooth. Where the angle passes a point, integrators cannot see what
    is not smooth: of 21 points of a cubic, at a tolerance of 1e-9 over 15 swings, rk45 left 7e-9 with a spline and 1e-5
    with "monotone", dop853 5e-6 and 4e-6. With "located": true (the default of "monotone" with up to 50 points, and not
    possible with more) points are events, at which steps end: that left 3e-8 with rk45 and 1e-10 with dop853, for two
    to five times the evaluations. integrator="auto" takes rk45 where there is a table. Outside its points a table goes
    on straight, with the slope that it ends with.

    Raises DesignError for tables that do not ascend or are not finite, ExpressionError for expressions outside the
    language, and for torques whose energy has no closed form here: give the energy then.
    """

    laws: Annotated[
        Mapping[str, LawData],
        PlainValidator(_laws),
        WithJsonSchema({"type": "object", "additionalProperties": dict(LAW_SCHEMA)}),
        Field(description="by joint name"),
    ] = field(default_factory=dict)

    name: ClassVar[str] = "nonlinear_stiffness"
    summary: ClassVar[str] = "Nonlinear stiffness of hinges"
    example: ClassVar[str] = (
        "nonlinear_stiffness: {knee: [3e-4, 0, 1e-3], hip: {table: [[-1, -2e-3], [0, 0], [1, 3e-3]]}}"
    )
    source: ClassVar[str] = "T = -dW/dq, W the antiderivative of the given law"

    shorthand: ClassVar[str] = "laws"
    absent: ClassVar[str] = "no law of a hinge's torque is given"

    def claims(self) -> tuple[str, ...]:
        """The stiffness of each of its hinges."""
        return tuple(stiffness_claim(joint) for joint in self.laws)

    def contribute(self, loads: Loads) -> None:
        for joint in self.laws:
            loads.hinge(joint)
        for hinge in loads.hinges():
            joint = hinge.joint.name
            if joint not in self.laws:
                continue
            angle = hinge.angle
            if hinge.joint.rest_angle:
                angle = angle - loads.parameter(
                    f"{joint}.rest_angle", hinge.joint.rest_angle, "rad", "angle at which the hinge rests"
                )
            assert isinstance(angle, Value), "a hinge's angle is a symbol"
            law = law_of(self.laws[joint], f"the stiffness of hinge {joint!r}")
            torque, energy = law.staged(loads, joint, angle)
            loads.hinge_torque(joint, -torque)
            loads.stored_energy(energy)

    def carry_over(self, engine: "EngineLoads") -> None:
        """Laws that are straight lines; engines have no others."""
        for joint, data in self.laws.items():
            hinge = engine.mechanism.joint(joint)
            if isinstance(data, tuple) and not any(data[1:]):
                engine.hinge_spring(joint, data[0])
                engine.hinge_rest(joint, data[0], hinge.rest_angle)
            else:
                engine.lose(f"the nonlinear stiffness of hinge {joint!r}")
