"""What a fit takes: a pendulum's stiffness and damping, and ten numbers of three links from three recordings.

    python -m benchmarks.fits

Prints seconds of a fit whose model is compiled, its runs, and how many plain runs would take as long. Recordings are
made by the model itself, with noise.
"""

import time
from collections.abc import Callable

import numpy as np

import lamc
from lamc import examples

NOISE = 0.01  # rad


def flap() -> tuple[lamc.Mechanism, lamc.Scene]:
    """A flap of 2 g on a soft hinge, let go at half a radian."""
    ground = lamc.Body(name="ground", fixed=True)
    body = lamc.Body(name="flap", mass=2e-3, com=(0.0, 0.0, -0.02), inertia=np.diag([4e-7, 4e-7, 1e-8]))
    hinge = lamc.Joint(
        name="h", parent="ground", child="flap", axis=(0.0, 1.0, 0.0), stiffness=2e-3, damping=1e-5
    )
    return lamc.Mechanism(name="flap", bodies=(ground, body), joints=(hinge,)), lamc.Scene(angles={"h": 0.5})


def measured(title: str, fit: "lamc.Fit", seconds: float, plain: float) -> None:
    print(f"{title:<28} {seconds * 1e3:8.1f} ms  {fit.runs:5d} runs, {seconds / plain:6.1f} plain runs' time")


def main() -> None:
    mechanism, scene = flap()
    t = np.linspace(0.0, 2.0, 201)
    sim = lamc.compile(mechanism, scene)
    run = sim.run(t_end=2.0, t_eval=t, parameters={"h.stiffness": 3e-3, "h.damping": 2e-5})
    values = run.angle("h") + NOISE * np.random.default_rng(0).normal(size=len(t))
    timed(
        "pendulum",
        mechanism,
        scene,
        [lamc.Recording(t, {"h": values})],
        {"h.stiffness": None, "h.damping": None},
    )

    design = lamc.load(examples.find("pendulum").path)
    rng = np.random.default_rng(1)
    free = [f"h{k}.{what}" for k in (1, 2, 3) for what in ("stiffness", "damping")]
    free += ["link_2.mass", "link_3.mass", "link_2.inertia_zz", "link_3.inertia_zz"]
    data = []
    for k in range(3):
        start = lamc.Scene(angles={"h1": 0.3 * k, "h2": -0.4 * k + 0.2, "h3": 0.5})
        three = lamc.compile(design, start)
        true = {
            name: value * np.exp(0.3 * np.sin(i)) for i, (name, value) in enumerate(three.parameters.items())
        }
        made = three.run(t_end=2.0, t_eval=t, parameters={name: true[name] for name in free})
        columns = {name: made.angle(name) + NOISE * rng.normal(size=len(t)) for name in made.joints}
        data.append(lamc.Recording(t, columns, angles=dict(start.angles)))
    timed("ten numbers, 3 recordings", design, None, data, dict.fromkeys(free))


def timed(
    title: str, design: object, scene: lamc.Scene | None, data: list[lamc.Recording], free: dict[str, None]
) -> None:
    """The quickest fit of ten, and the quickest of twenty plain runs."""
    fit = lamc.fit(design, data, free, scene)  # type: ignore[arg-type]
    seconds = min(took(lambda: lamc.fit(design, data, free, scene)) for _ in range(10))  # type: ignore[arg-type]
    sim = lamc.compile(design, scene)  # type: ignore[arg-type]
    plain = min(took(lambda: sim.run(t_end=2.0, t_eval=data[0].t, rtol=1e-10, atol=1e-12)) for _ in range(20))
    measured(title, fit, seconds, plain * len(data))


def took(work: Callable[[], object]) -> float:
    """Seconds of processor time, which neighbours do not make longer."""
    began = time.process_time()
    work()
    return time.process_time() - began


if __name__ == "__main__":
    main()
