"""Makes docs/flap1.csv and docs/flap2.csv: recordings of a flap as a phone's camera would make them. None was there.

    python docs/make_fit_data.py

The right flap of the example `flaps`, with a hinge softer and more damped than drawn, is let go at 40 and at -25
degrees and simulated. A camera beside it sees two marks in a picture of 1920 by 1080 pixels, 240 times a second: one at
the flap's tip, one on the plate that is held. It stands a little aslant, its noise is that of a tracker, 0.3 pixels; it
loses a frame now and then, and its clock is 7 ms late. What a fit should find is HIDDEN.
"""

from pathlib import Path

import numpy as np

import lamc
from lamc import examples

FOLDER = Path(__file__).resolve().parent
HIDDEN = {"right.stiffness": 3.1e-3, "right.damping": 4.2e-6}  # N·m/rad, N·m·s/rad; drawn: 4e-3, 2e-6
RELEASED = (40.0, -25.0)  # degrees
RATE, FRAMES = 240.0, 121  # 1/s
DELAY = 7e-3  # s
NOISE = 0.3  # pixels
LOST = 0.08  # of frames
SCALE, TURN, ORIGIN = 14_000.0, np.radians(1.5), (620.0, 540.0)  # pixels a metre, rad, pixels
TIP_BODY, PLATE_BODY = "link_2", "ground"
TIP, PLATE = (0.058, 0.0, 0.0), (-0.015, 0.0, 0.0)  # m, as drawn
REMARK = "# Made by docs/make_fit_data.py from a simulated camera: noise, lost frames and a late clock are not real."


def main() -> None:
    """Writes both recordings."""
    design = lamc.load(examples.find("flaps").path)
    for k, angle in enumerate(RELEASED, start=1):
        points = (lamc.OutputPoint("tip", TIP_BODY, TIP), lamc.OutputPoint("plate", PLATE_BODY, PLATE))
        scene = lamc.Scene(angles={"right": np.radians(angle)}, outputs=points)
        t = np.arange(FRAMES) / RATE
        run = lamc.compile(design, scene).run(t_end=float(t[-1]), t_eval=t, parameters=HIDDEN)
        write(FOLDER / f"flap{k}.csv", t, [run.point("tip"), run.point("plate")], np.random.default_rng(k))


def write(path: Path, t: np.ndarray, points: list[np.ndarray], rng: np.random.Generator) -> None:
    """One recording: times and pixels; lost frames are empty."""
    c, s = np.cos(TURN), np.sin(TURN)
    columns = []
    for p in points:
        u, v = p[:, 0], -p[:, 2]  # to the right, and down
        columns += [SCALE * (c * u - s * v) + ORIGIN[0], SCALE * (s * u + c * v) + ORIGIN[1]]
    lines = [REMARK, "t [s],tip.x [px],tip.y [px],plate.x [px],plate.y [px]"]
    lost = rng.random(len(t)) < LOST
    noise = NOISE * rng.normal(size=(len(t), 4))
    for k, time in enumerate(t):
        cells = ["" if lost[k] else f"{column[k] + noise[k, j]:.2f}" for j, column in enumerate(columns)]
        lines.append(",".join([f"{time + DELAY:.5f}", *cells]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
