const TITLES = { angles: "Angles", outputs: "Outputs", coordinates: "Coordinates", energies: "Energy" };

const eventsOf = (events) => (events ? Array.from(events.t, (t, k) => [t, events.names[events.kind[k]]]) : []);

/** One run of a device, or a mechanism to be folded by hand: its stage, curves, sliders, and the model where there is one */
class Device {
  constructor(data, player) {
    Object.assign(this, { data, player, motion: null, events: eventsOf(data.events), problem: "" });
    this.kinematics = new Kinematics(data);
    this.drawn = data.bodies.map((body) => body.com);
    this.angles = data.hinges.map((_, k) => data.start[k] ?? 0);
    this.recorded = data.recording ? Motion.recorded(data.recording) : null;
    this.motion = this.recorded;
    this.duration = data.duration;
    this.stage = new Stage(data, this.home(), data.description);
    this.engine = null;
    this.changed = { parameters: {}, inputs: {}, angles: {} };
    this.sliders = { angles: [], model: [] };
    this.curves = this.makeCurves();
    this.status = el("p", { className: "status", role: "status" });
    this.side = el("div", { className: "side" });
    this.side.append(this.status);
    this.charts = el("div", { className: "charts" }, ...this.curves.map((each) => each.element));
    const label = data.label ? [el("h2", { textContent: data.label })] : [];
    this.element = el("article", { className: "show" }, ...label, el("div", { className: "pair" }, this.stage.element, this.side), this.charts);
    this.makeAngles();
    this.side.classList.toggle("empty", this.sliders.angles.length === 0);
    this.curves.forEach((each) => this.motion && each.show(this.motion, this.duration, this.events));
    this.seek(0);
  }

  /** Where the eye is at first: all instants in sight, unless the device walks away */
  home() {
    const { mesh, sticks, hinges, moving } = this.data;
    const poses = new Float64Array(12 * this.drawn.length);
    this.drawn.forEach((_, b) => poses.set(STILL, 12 * b));
    const visitAt = (visit) => {
      const at = (body, array, k) => visit(placed(poses.subarray(12 * body, 12 * body + 12), [array[3 * k], array[3 * k + 1], array[3 * k + 2]]));
      mesh.triangles.forEach((p, k) => at(mesh.bodies[Math.floor(k / 3)], mesh.points, p));
      sticks.bodies.forEach((body, k) => [0, 1].forEach((i) => at(body, sticks.points, 2 * k + i)));
      hinges.forEach((hinge) => [0, 1].forEach((i) => at(hinge.parent, hinge.ends, i)));
    };
    const pose = (time) => {
      if (this.motion) this.motion.poses(time, moving, this.drawn, poses);
      else this.kinematics.poses(this.angles).forEach((pose, b) => poses.set(pose, 12 * b));
    };
    const count = this.motion ? clamp(Math.round(3e5 / (mesh.triangles.length + 1)), 6, 40) : 1;
    const instants = Array.from({ length: count }, (_, k) => (this.duration * k) / Math.max(count - 1, 1));
    const balls = instants.map((time) => {
      pose(time);
      return { ...ballOf(visitAt), middle: this.middleOf(poses) };
    });
    const first = balls[0];
    const whole = ballOf((visit) => instants.forEach((time) => {
      pose(time);
      visitAt(visit);
    }));
    const own = Math.max(...balls.map((each) => each.radius));
    const way = Math.max(...balls.map((each) => norm(minus(each.middle, first.middle))));
    const wanders = this.data.walks && way > 0.8 * own;
    const { azimuth, elevation } = this.data.view ?? EYE;
    const floor = Math.min(...balls.map((each) => each.low[2])) - 0.12 * whole.radius;
    if (wanders) return { centre: first.centre, middle: first.middle, radius: 1.15 * own, azimuth, elevation, wanders, floor };
    return { centre: whole.centre, middle: first.middle, radius: whole.radius, azimuth, elevation, wanders: false, floor };
  }

  middleOf(poses) {
    const free = this.data.bodies.map((body, b) => [body, b]).filter(([body]) => !body.fixed);
    const all = free.length > 0 ? free : this.data.bodies.map((body, b) => [body, b]);
    return times(1 / all.length, all.reduce((sum, [body, b]) => plus(sum, placed(poses.subarray(12 * b, 12 * b + 12), body.com)), [0, 0, 0]));
  }

  makeCurves() {
    const groups = new Map();
    this.data.curves.forEach((spec, at) => {
      const key = `${spec.group}|${spec.unit}`;
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push({ ...spec, at });
    });
    return [...groups.entries()].map(([key, specs]) => new Curves(TITLES[key.split("|")[0]], specs, (t) => this.player.seek(t)));
  }

  // --- time -----------------------------------------------------------------------------------------------------------

  seek(time) {
    this.time = time;
    if (this.motion) this.motion.poses(time, this.data.moving, this.drawn, this.stage.poses);
    this.stage.draw();
    this.curves.forEach((each) => each.at(this.driver ? time : Math.min(time, this.duration)));
  }

  show(motion, events) {
    Object.assign(this, { motion, events });
    this.curves.forEach((each) => each.show(motion, this.duration, events));
    this.seek(this.time);
    this.player.refresh();
  }

  // --- angles ---------------------------------------------------------------------------------------------------------

  /** Sliders of all hinges: the position to fold to, and where a run of the model begins */
  makeAngles() {
    const { hinges, recording, live } = this.data;
    if (hinges.length === 0 || (recording && !live)) return;
    const isRun = recording !== null || live !== null;
    this.sliders.angles = hinges.map((hinge, joint) => {
      const [least, most] = hinge.limits ?? [-Math.PI, Math.PI];
      const member = { name: hinge.name, value: this.angles[joint], least, most, ...this.degrees() };
      return new Slider(member, (value, done) => this.turn(joint, value, done));
    });
    this.side.append(group(isRun ? "Start angles" : "Fold", this.sliders.angles, hinges.length <= 12 || !isRun));
    if (!isRun) {
      this.fold();
      this.side.append(el("div", { className: "buttons" }, el("button", { type: "button", textContent: "Reset", onclick: () => this.reset() })));
    }
  }

  degrees() {
    return { factor: 180 / Math.PI, unit: "°" };
  }

  turn(joint, value, done) {
    const next = this.kinematics.turnedTo(this.angles, joint, value, this.wayOut(joint));
    const reached = Math.abs(next[joint] - value) < 1e-9;
    this.angles = next;
    this.changed.angles[this.data.hinges[joint].name] = next[joint];
    this.sliders.angles.forEach((slider, k) => k !== joint && slider.put(next[k]));
    if (!reached) this.sliders.angles[joint].refuse(`stops at ${fixed((next[joint] * 180) / Math.PI, 0.1)}°: the loops go no farther this way`);
    else this.sliders.angles[joint].refuse("");
    if (this.engine === null) this.fold();
    else if (this.driver) this.drive(true);
    else this.again(done);
  }

  /** Rates by which a hinge leaves a singular position, such as the flat one */
  wayOut(joint) {
    return (this.data.ways ?? []).find((rates) => Math.abs(rates[joint]) > 1e-6) ?? null;
  }

  fold() {
    this.kinematics.poses(this.angles).forEach((pose, b) => this.stage.poses.set(pose, 12 * b));
    this.stage.draw();
  }

  /** Sliders as they were; a model does more */
  reset() {
    this.changed = { parameters: {}, inputs: {}, angles: {} };
    this.angles = this.data.hinges.map((_, k) => this.data.start[k] ?? 0);
    this.sliders.angles.forEach((slider, k) => {
      slider.put(this.angles[k]);
      slider.refuse("");
    });
    if (this.engine === null) this.fold();
  }

  tell(text) {
    this.status.textContent = text;
  }
}
