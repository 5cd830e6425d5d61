"""The simulator that an export is made of: the scene's, with torques that come from outside.

In: a mechanism, its scene, options. Out: a compiled `Simulator`. Never: changes what the scene says
of such torques itself.
"""

from dataclasses import replace

from lamc.basics.errors import ExportError
from lamc.basics.places import located_at
from lamc.effects.external_torque import ExternalTorque
from lamc.export.options import ExportOptions
from lamc.pipeline import compile as compile_
from lamc.pipeline import effects_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.defaults import DURATION
from lamc.run.request import did_you_mean
from lamc.run.simulator import Simulator
from lamc.run.start_checks import check_run


def simulator_of(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> Simulator:
    """Compiles the scene with the inputs that `options` ask for. With all torques zero its motion is that of the scene,
    to the last bit. Raises ExportError for a hinge that is not there, and for inputs chosen twice; and as a run of
    `run_length` does where it does not begin, such as for a motion of the base with a kink: no run of the export would
    be right."""
    simulator = compile_(mechanism, driven_scene(mechanism, scene, options))
    motion = simulator.model.motion({})
    with located_at(simulator.scene.places):
        check_run(simulator.effects, mechanism, motion, simulator.start, run_length(simulator.scene))
    return simulator


def run_length(scene: Scene) -> float:
    """How long a run of the scene is where nobody says, s."""
    return scene.duration or DURATION


def driven_scene(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> Scene:
    """The scene with a torque from outside on each hinge that `options.inputs` names."""
    names = tuple(joint.name for joint in mechanism.joints)
    wanted = names if options.inputs == "hinges" else () if options.inputs == "none" else options.inputs
    for name in wanted:
        if name not in names:
            raise ExportError(
                f"--inputs (inputs) names the hinge {name!r}, which is not there; {did_you_mean(name, names)}"
            )
    is_said = any(effect.name == ExternalTorque.name for effect in effects_of(mechanism, scene))
    is_said = is_said or ExternalTorque.name in scene.without
    if is_said and options.inputs != "hinges":
        raise ExportError(
            f"--inputs (inputs) is {options.inputs!r}, and the scene says itself which torques come from outside "
            f"({ExternalTorque.name}); leave out one of the two"
        )
    if is_said or not wanted:
        return scene
    joints = None if options.inputs == "hinges" else tuple(wanted)
    return replace(scene, added=(*scene.added, ExternalTorque(joints)))
