const QUICK = 14; // ms: a run that takes less is done anew while one drags
const WINDOW = 10; // s: what curves show of a model that runs on
const DRIVEN = 4000; // rows that are kept of it
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

  // --- the model ------------------------------------------------------------------------------------------------------

  /** Puts the model into the page: simulatorOf and the compiled module */
  async enliven(simulatorOf, source) {
    const { live } = this.data;
    this.module = await WebAssembly.compile(live.wasm);
    this.engine = new Engine(simulatorOf(this.module));
    this.source = source;
    this.base = this.engine.begin(this.order()).q;
    this.makeModelSliders();
    this.stage.element.append(el("span", { className: "badge", textContent: "live", title: "The model is in this page: change its numbers" }));
    if (this.recorded === null) {
      this.last = this.motion = new Motion(this.data.moving.length, this.data.curves.length, 1);
      const it = this.engine.begin(this.order());
      this.take(this.motion, Float64Array.from(this.engine.row(it)));
      it.free();
      const home = this.home();
      home.radius *= 1.25;
      Object.assign(this.stage, { home, follows: home.wanders });
      Object.assign(this.stage.camera, { home });
      this.stage.camera.reset();
    }
  }

  makeModelSliders() {
    const slider = (kind) => (member) => {
      const range = rangeOf(member.value, member.least, member.most);
      const isAngle = member.unit === "rad";
      const shown = isAngle ? this.degrees() : { unit: member.unit === "1" ? "" : member.unit };
      const bounds = isAngle ? { least: Math.max(member.least ?? -Math.PI, -Math.PI), most: Math.min(member.most ?? Math.PI, Math.PI), log: false } : range;
      const made = new Slider({ name: member.name, title: member.meaning, value: member.value, ...bounds, ...shown }, (value, done) => {
        this.changed[kind][member.field] = value;
        if (this.driver) this.steer(kind, member.field, value, made);
        else this.again(done, made);
      });
      return made;
    };
    const { inputs, parameters } = this.data.live;
    const sections = [];
    if (inputs.length > 0) sections.push(["Inputs", inputs.map(slider("inputs")), true]);
    const titles = [...new Set(parameters.map((each) => each.group))];
    titles.forEach((title, k) => {
      const made = parameters.filter((each) => each.group === title).map(slider("parameters"));
      sections.push([title, made, k === 0 && inputs.length === 0 && made.length <= 12]);
    });
    this.sliders.model = sections.flatMap(([, made]) => made);
    this.side.classList.remove("empty");
    this.side.append(...sections.map(([title, made, open]) => group(title, made, open)));
    const copy = el("button", { type: "button", textContent: "Copy as scene", onclick: () => this.copy() });
    this.side.append(el("div", { className: "buttons" }, el("button", { type: "button", textContent: "Reset", onclick: () => this.reset() }), copy));
  }

  order() {
    const { parameters, inputs, angles } = this.changed;
    const rows = clamp(Math.round((30 * this.duration) / this.data.speed), 151, 1201);
    let q = null;
    if (Object.keys(angles).length > 0) {
      q = Array.from(this.base);
      this.data.order.forEach((joint, k) => (q[k] = this.angles[joint]));
    }
    const { given, settings } = this.data.live;
    return { duration: this.duration, rows, settings, parameters: { ...given.parameters, ...parameters }, inputs: { ...given.inputs, ...inputs }, q, u: null };
  }

  /** Values of the curves in a row of the engine */
  append(motion, numbers, first) {
    const { places, sizes } = this.engine;
    const poses = Array.from({ length: sizes[4] / 12 }, (_, b) => numbers.subarray(first + places[4] + 12 * b, first + places[4] + 12 * b + 12));
    const values = this.data.curves.map(({ from: [kind, index, body, ...point] }) => {
      if (kind === "angle") return numbers[first + places[3] + index];
      if (kind === "q") return numbers[first + places[1] + index];
      if (kind === "energy") return numbers[first + places[5] + index];
      if (kind === "total") return numbers[first + places[6]];
      const b = this.data.moving.indexOf(body);
      if (b < 0) return point[index];
      const arm = minus(point, this.drawn[body]);
      return poses[b][index] + dot(Array.from(poses[b].subarray(3 + 3 * index, 6 + 3 * index)), arm);
    });
    motion.append(numbers[first], poses, values);
  }

  take(motion, numbers) {
    for (let k = 0; k < numbers.length; k += this.engine.width) this.append(motion, numbers, k);
  }

  /** The run with the numbers as they are. done: nothing is being dragged any more */
  again(done, slider = null) {
    if (this.engine === null) return;
    const isQuick = this.cost !== undefined && this.cost <= QUICK;
    if (!isQuick && !done) return;
    const order = this.order();
    const motion = new Motion(this.data.moving.length, this.data.curves.length, order.rows);
    this.order_ = order;
    if (isQuick) {
      this.id = (this.id ?? 0) + 1;
      const began = performance.now();
      const problem = this.engine.run(order, (numbers) => this.take(motion, numbers));
      this.cost = 0.7 * this.cost + 0.3 * (performance.now() - began);
      this.finish(motion, problem, slider);
    } else this.behind(order, motion, slider);
  }

  finish(motion, problem, slider) {
    if (slider) slider.refuse(problem && motion.filled < 2 ? problem : "");
    this.tell(problem ?? "");
    this.settled = problem === null;
    if (motion.filled > 0) this.show(motion, []);
  }

  /** In a worker, so that the page stays quick; rows appear as they come */
  behind(order, motion, slider) {
    this.id = (this.id ?? 0) + 1;
    const id = this.id;
    this.settled = false;
    const began = performance.now();
    const here = () => {
      const problem = this.engine.run(order, (numbers) => this.take(motion, numbers));
      this.cost = performance.now() - began;
      this.finish(motion, problem, slider);
    };
    if (this.worker === undefined) this.worker = this.makeWorker();
    if (this.worker === null) return here();
    this.worker.onerror = () => {
      this.worker = null;
      here();
    };
    this.worker.onmessage = ({ data }) => {
      if (data.id !== this.id) return;
      this.take(motion, data.rows);
      if (data.done) {
        this.cost = performance.now() - began;
        this.finish(motion, data.problem ?? null, slider);
      } else this.show(motion, []);
    };
    this.worker.postMessage({ ...order, id });
    return undefined;
  }

  makeWorker() {
    try {
      const text = `"use strict";\n${this.source}\nserve(globalThis.lamcEngines[0]);`;
      const worker = new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
      worker.postMessage({ module: this.module });
      return worker;
    } catch {
      return null; // some frames allow none: the page waits for the run then
    }
  }

  reset() {
    this.changed = { parameters: {}, inputs: {}, angles: {} };
    this.angles = this.data.hinges.map((_, k) => this.data.start[k] ?? 0);
    this.sliders.angles.forEach((slider, k) => slider.put(this.angles[k]));
    this.sliders.model.forEach((slider) => slider.put(slider.start));
    [...this.sliders.angles, ...this.sliders.model].forEach((slider) => slider.refuse(""));
    this.id = (this.id ?? 0) + 1;
    this.tell("");
    this.settled = true;
    if (this.engine === null) this.fold();
    else if (this.driver) this.drive(true);
    else if (this.recorded) this.show(this.recorded, eventsOf(this.data.events));
    else this.again(true);
  }

  // --- hands on -------------------------------------------------------------------------------------------------------

  /** On: the model begins anew and runs on for as long as one likes, and sliders act at once. Off: the run is back. */
  drive(on) {
    this.driver?.free();
    this.driver = null;
    this.id = (this.id ?? 0) + 1;
    this.tell("");
    if (on) {
      this.driver = this.engine.begin({ ...this.order(), duration: Infinity });
      this.motion = new Motion(this.data.moving.length, this.data.curves.length, DRIVEN);
      this.advance(0);
    } else if (Object.values(this.changed).some((each) => Object.keys(each).length > 0) || !this.recorded) this.again(true);
    else this.show(this.recorded, eventsOf(this.data.events));
  }

  /** Goes on for some seconds; false where the model cannot */
  advance(seconds) {
    if (!this.driver) return true;
    const it = this.driver;
    try {
      it.step(it.t + seconds);
    } catch (error) {
      this.tell(`Stopped at t = ${Number(it.t.toPrecision(6))} s: ${error.reason ?? error.message}. Reset begins anew.`);
      return false;
    }
    this.motion.forget();
    this.take(this.motion, Float64Array.from(this.engine.row(it)));
    this.events = [];
    const end = Math.max(it.t, WINDOW);
    this.curves.forEach((each) => each.show(this.motion, end, [], end - WINDOW));
    return true;
  }

  steer(kind, field, value, slider) {
    try {
      if (kind === "inputs") this.driver.setInputs({ [field]: value });
      else this.driver.setParameters({ [field]: value });
      slider.refuse("");
    } catch (error) {
      slider.refuse(error.reason ?? error.message);
    }
  }

  async copy() {
    const named = (kind) => Object.fromEntries(Object.entries(this.changed[kind]).map(([field, value]) => [this.data.live[kind].find((each) => each.field === field).name, value]));
    const text = sceneText(this.data.scene ?? {}, { angles: this.changed.angles, inputs: named("inputs"), parameters: named("parameters") });
    const box = el("textarea", { className: "copied", rows: 8, readOnly: true, value: text, "aria-label": "the scene" });
    this.side.querySelector(".copied")?.remove();
    this.side.append(box);
    box.select();
    try {
      await navigator.clipboard.writeText(text);
      this.tell(`Copied: save it as scene.yaml, then lamc run FILE --scene scene.yaml${this.data.sceneNote ?? ""}`);
    } catch {
      this.tell("Copy the selected text below: this frame may not write to the clipboard.");
    }
    return text;
  }

  tell(text) {
    this.status.textContent = text;
  }
}
