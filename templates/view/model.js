const QUICK = 14; // ms: a run that takes less is done anew while one drags
const WINDOW = 10; // s: what curves show of a model that runs on
const DRIVEN = 4000; // rows that are kept of it

/** A device whose model is in the page: runs of it, and it itself in one's hands */
class LiveDevice extends Device {
  driver = null; // an instance that runs on, while one drives
  id = 0; // of the newest order

  /** Puts the model into the page: simulatorOf and the compiled module */
  async enliven(simulatorOf, source) {
    const { live } = this.data;
    this.module = await WebAssembly.compile(live.wasm);
    this.engine = new Engine(simulatorOf(this.module));
    this.source = source;
    const first = this.engine.begin(this.order());
    [this.base, this.baseRates] = [Array.from(first.q), Array.from(first.u)];
    first.free();
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
      const range = rangeOf(member);
      const isAngle = member.unit === "rad";
      const shown = isAngle ? this.degrees() : { unit: member.unit === "1" ? "" : member.unit };
      const bounds = isAngle ? { least: Math.max(member.least ?? -Math.PI, -Math.PI), most: Math.min(member.most ?? Math.PI, Math.PI), log: false } : range;
      const made = new Slider({ name: member.name, title: member.meaning, value: member.value, ...bounds, ...shown }, (value, done) => {
        this.changed[kind][member.field] = value;
        if (this.driver) this.steer(kind, { [member.field]: value }, made);
        else this.again(done, made);
      });
      made.field_ = member.field;
      return made;
    };
    const { data } = this;
    const { inputs, parameters } = data.live;
    const sections = [];
    if (inputs.length > 0) sections.push(["Inputs", inputs.map(slider("inputs")), true]);
    const titles = [...new Set(parameters.map((each) => each.group))];
    titles.forEach((title, k) => {
      const made = parameters.filter((each) => each.group === title).map(slider("parameters"));
      if (title !== "Bodies") this.addTogether(made);
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
    let [q, u] = [null, null];
    this.unfit = "";
    if (Object.keys(angles).length > 0) {
      q = Array.from(this.base);
      this.data.order.forEach((joint, k) => (q[k] = this.angles[joint]));
      u = this.startRates();
    }
    const { given, settings } = this.data.live;
    return { duration: this.duration, rows, settings, parameters: { ...given.parameters, ...parameters }, inputs: { ...given.inputs, ...inputs }, q, u };
  }

  /** Rates at angles that were changed: where loops close, others follow from the scene's than where it starts */
  startRates() {
    const { hinges, order, rates } = this.data;
    if (this.kinematics.tree.cuts.length === 0 || order.length < hinges.length || !rates.some((rate) => rate)) return null;
    const found = this.kinematics.rates(this.angles, rates);
    if (!found.fits) this.unfit = "The scene's rates are no motion at these angles: the run begins with the nearest.";
    const u = Array.from(this.baseRates);
    order.forEach((joint, k) => (u[k] = found.rates[joint]));
    return u;
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

  /** Rows, and events of them: times and kinds by turns, as `found` gets them by name */
  take(motion, numbers, found = [], events = []) {
    for (let k = 0; k < numbers.length; k += this.engine.width) this.append(motion, numbers, k);
    const { duration, engine: { model } } = this;
    for (let k = 0; k < events.length; k += 2) {
      if (events[k] <= duration) found.push([events[k], model.events[events[k + 1]].name]);
    }
  }

  /** The run with the numbers as they are. done: nothing is being dragged any more */
  again(done, slider = null) {
    if (this.engine === null) return;
    const isQuick = this.cost !== undefined && this.cost <= QUICK;
    if (!isQuick && !done) {
      if (slider === null && !this.data.walks) this.fold(); // an angle is dragged: at least where it begins
      return;
    }
    const order = this.order();
    const motion = new Motion(this.data.moving.length, this.data.curves.length, order.rows);
    const found = [];
    if (isQuick) {
      this.id += 1;
      const began = performance.now();
      const problem = this.engine.run(order, (numbers, events) => this.take(motion, numbers, found, events));
      this.cost = 0.7 * this.cost + 0.3 * (performance.now() - began);
      this.finish(motion, found, problem, slider);
    } else this.behind(order, motion, slider);
  }

  finish(motion, events, problem, slider) {
    if (slider) slider.refuse(problem && motion.filled < 2 ? problem : "");
    this.tell(problem ?? this.unfit);
    this.settled = problem === null;
    if (motion.filled > 0) this.show(motion, events);
  }

  /** In a worker, so that the page stays quick; rows appear as they come */
  behind(order, motion, slider) {
    this.id += 1;
    const id = this.id;
    this.settled = false;
    const began = performance.now();
    const found = [];
    const here = () => {
      const problem = this.engine.run(order, (numbers, events) => this.take(motion, numbers, found, events));
      this.cost = performance.now() - began;
      this.finish(motion, found, problem, slider);
    };
    if (this.worker === undefined) this.worker = this.makeWorker();
    if (this.worker === null) return here();
    this.worker.onerror = () => {
      this.worker = null;
      here();
    };
    this.worker.onmessage = ({ data }) => {
      if (data.id !== this.id) return;
      this.take(motion, data.rows, found, data.events);
      if (data.done) {
        this.cost = performance.now() - began;
        this.finish(motion, found, data.problem ?? null, slider);
      } else this.show(motion, found);
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
    super.reset();
    if (this.engine === null) return;
    this.sliders.model.forEach((slider) => {
      slider.put(slider.start);
      slider.refuse("");
    });
    this.id += 1;
    this.tell("");
    this.settled = true;
    if (this.driver) this.drive(true);
    else if (this.recorded) this.show(this.recorded, eventsOf(this.data.events));
    else this.again(true);
  }

  // --- hands on -------------------------------------------------------------------------------------------------------

  /** On: the model begins anew and runs on for as long as one likes, and sliders act at once. Off: the run is back. */
  drive(on) {
    this.driver?.free();
    this.driver = null;
    this.id += 1;
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

  /** Above sliders that are alike, one for all of them */
  addTogether(sliders) {
    const all = together(sliders, (moved, done) => {
      const values = Object.fromEntries(moved.map((each) => [each.field_, each.value]));
      Object.assign(this.changed.parameters, values);
      if (this.driver) this.steer("parameters", values, all);
      else this.again(done, all);
    });
    if (all === null) return;
    all.isAll = true;
    sliders.unshift(all);
  }

  steer(kind, values, slider) {
    try {
      if (kind === "inputs") this.driver.setInputs(values);
      else this.driver.setParameters(values);
      slider.refuse("");
    } catch (error) {
      slider.refuse(error.reason ?? error.message);
    }
  }

  async copy() {
    const { given } = this.data.live; // what the run was given besides its scene
    const named = (kind) => Object.fromEntries(Object.entries({ ...given[kind], ...this.changed[kind] }).map(([field, value]) => [this.data.live[kind].find((each) => each.field === field).name, value]));
    const base = this.data.scene ?? {};
    const isSaid = (name) => name in this.changed.angles || name in (base.angles ?? {}); // others of a loop have followed
    const turned = Object.keys(this.changed.angles).length === 0 ? [] : this.data.hinges.flatMap(({ name }, k) => (isSaid(name) ? [[name, this.angles[k]]] : []));
    const text = sceneText(base, { angles: Object.fromEntries(turned), inputs: named("inputs"), parameters: named("parameters") });
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
}
