/**
 * Runs of a model in WebAssembly as `Simulator.run(t_end, t_eval)` in Python has them: the same integrator ("auto"), the
 * same tolerances, no step beyond the end, rows from the continuous extension of steps.
 *
 * order: { duration, rows, parameters, inputs, settings (rtol, atol), q, u } with q and u null for the scene's own start. Rows go to `take` in
 * blocks of numbers: t, q, u, angles, poses of moving bodies (12 each), energies, their sum.
 */
const LOOKS = 1200; // in a run: of events that are nearer to each other, one is marked

class Engine {
  constructor(model) {
    this.model = model;
    const { coordinates, rates, joints, bodies, energies } = model;
    this.sizes = [1, coordinates.length, rates.length, joints.length, 12 * bodies.length, energies.length, 1];
    this.width = this.sizes.reduce((sum, n) => sum + n, 0);
    this.places = this.sizes.map((_, k) => this.sizes.slice(0, k).reduce((sum, n) => sum + n, 0));
  }

  /** An instance at the start of an order */
  begin({ duration, parameters, inputs, settings, q, u }) {
    const it = this.model.create({ parameters, settings: { ...settings, tStop: duration } });
    if (Object.keys(inputs).length > 0) it.setInputs(inputs);
    if (q !== null) it.start(0, q, u ?? it.u);
    return it;
  }

  /** One row of numbers */
  row(it) {
    const { angle, pose, energy, totalEnergy } = it.outputs();
    return [it.t, ...it.q, ...it.u, ...angle, ...pose.flatMap((each) => Array.from(each)), ...energy, totalEnergy];
  }

  /** To row k of an order. Its events go to `found`, [s, kind, ...]: of those within a part of the row, the last one. */
  step(it, { duration, rows }, k, found) {
    const at = (row) => (row === rows - 1 ? duration : (duration * row) / (rows - 1));
    if (this.model.events === undefined) return it.step(at(k));
    const parts = Math.ceil(LOOKS / rows);
    for (let i = parts - 1; i >= 0; i--) {
      const { count } = it.events();
      it.step(Math.max(it.t, at(k - i / parts)));
      const last = it.events();
      if (last.count > count) found.push(last.t, last.kind);
    }
    return undefined;
  }

  /** take: (rows, events) gets what there is. Returns what stopped it, or null. */
  run(order, take) {
    let it = null;
    const [rows, events] = [[], []];
    try {
      it = this.begin(order);
      for (let k = 0; k < order.rows; k++) {
        this.step(it, order, k, events);
        rows.push(this.row(it));
      }
      return null;
    } catch (error) {
      return `${it === null ? "" : `stopped at t = ${Number(it.t.toPrecision(6))} s: `}${error.reason ?? error.message}`;
    } finally {
      take(Float64Array.from(rows.flat()), events);
      it?.free();
    }
  }
}

/** In a worker: makes the engine of the first message, and runs the orders of those that follow, one after another. */
function serve(simulatorOf) {
  let engine = null;
  let newest = 0;
  let busy = Promise.resolve();
  const pause = () => new Promise((go) => setTimeout(go, 0)); // lets a newer order in
  const work = async (order) => {
    if (order.id !== newest) return;
    let [from, problem] = [0, null];
    let it = null;
    try {
      it = engine.begin(order);
      while (from < order.rows && order.id === newest) {
        const [rows, events] = [[], []];
        const began = performance.now();
        while (from < order.rows && performance.now() - began < 30) {
          engine.step(it, order, from, events);
          rows.push(engine.row(it));
          from += 1;
        }
        self.postMessage({ id: order.id, rows: Float64Array.from(rows.flat()), events, done: from === order.rows });
        await pause();
      }
    } catch (error) {
      problem = `${it === null ? "" : `stopped at t = ${Number(it.t.toPrecision(6))} s: `}${error.reason ?? error.message}`;
      self.postMessage({ id: order.id, rows: new Float64Array(0), done: true, problem });
    } finally {
      it?.free();
    }
  };
  self.onmessage = ({ data }) => {
    if (data.module) engine = new Engine(simulatorOf(data.module));
    else {
      newest = data.id;
      busy = busy.then(() => work(data));
    }
  };
}
