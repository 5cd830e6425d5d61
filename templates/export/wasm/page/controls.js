const LONGEST_FRAME = 0.05; // s: after a pause of the browser's the motion goes on, it does not jump

/** Rows with a name each and cells to be written into; text only, whatever the design's names are */
function rows(body, names, cells) {
  return names.map((name) => {
    const row = body.insertRow();
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = name;
    row.append(head);
    return Array.from({ length: cells }, () => row.insertCell());
  });
}

/** Fields of a form, each with a place for what is wrong with it. take: throws where the model refuses a value */
function fields(parent, members, take) {
  for (const { field, name, unit, default: value } of members) {
    const label = Object.assign(document.createElement("label"), { className: "field" });
    const input = Object.assign(document.createElement("input"), { type: "number", step: "any", title: String(value) });
    const wrong = Object.assign(document.createElement("output"), { className: "wrong", id: `wrong_${field}` });
    input.value = String(value).length > 12 ? Number(value.toPrecision(7)) : value;
    input.setAttribute("aria-describedby", wrong.id);
    label.append(`${name}${unit === "1" ? "" : `, ${unit}`}`, input);
    let held = value;
    input.addEventListener("change", () => {
      wrong.textContent = "";
      input.removeAttribute("aria-invalid");
      try {
        if (!Number.isFinite(input.valueAsNumber)) throw new RangeError("it takes a number");
        take(field, input.valueAsNumber);
        held = input.valueAsNumber;
        input.title = String(held);
      } catch (error) {
        input.setAttribute("aria-invalid", "true");
        wrong.textContent = `${name}: ${error.reason ?? error.message}; it stays at ${Number(held.toPrecision(7))}${unit === "1" ? "" : ` ${unit}`}`;
      }
    });
    parent.append(label, wrong);
  }
}

/** A number with as many places after the point as leave it `digits` where it is as large as `largest` */
function fixed(value, largest, digits) {
  const places = Math.min(12, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.max(largest, 1e-300)))));
  const text = value.toFixed(places);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

/** Numbers of one unit, all with the prefix that fits the largest of them: they compare */
function prefixed(values, unit, largest) {
  const power = largest > 0 ? Math.min(2, Math.max(-4, Math.floor(Math.log10(largest) / 3))) : 0;
  const prefix = { "-4": "p", "-3": "n", "-2": "µ", "-1": "m", 0: "", 1: "k", 2: "M" }[power];
  return values.map((value) => `${fixed(value / 1000 ** power, largest / 1000 ** power, 4)} ${prefix}${unit}`);
}

/** Angles in degrees, lengths in mm, as in the picture; other units as they are */
function shown(value, unit) {
  const [factor, places, told] = {
    "rad": [180 / Math.PI, 2, "°"],
    "rad/s": [180 / Math.PI, 1, " °/s"],
    "m": [1e3, 3, " mm"],
    "m/s": [1e3, 2, " mm/s"],
  }[unit] ?? [];
  if (factor === undefined) return `${value.toPrecision(5)}${unit === "1" ? "" : ` ${unit}`}`;
  const text = (factor * value).toFixed(places);
  return `${Number(text) === 0 ? text.replace("-", "") : text}${told}`;
}

async function main() {
  const model = await lamc[SHAPE.name].load();
  const chosen = { parameters: {}, inputs: {} };
  let simulator = null;
  let playing = false;
  let last = 0;

  // The rates of a base that floats are no derivatives of its coordinates: they have rows of their own.
  const isPaired = (i) => i < model.rates.length && model.rates[i].name === model.coordinates[i]?.name;
  const alone = model.rates.map((_, i) => i).filter((i) => !isPaired(i));
  const angles = rows(byId("angles"), model.coordinates.map((c) => c.name), 2);
  const others = rows(byId("angles"), alone.map((i) => model.rates[i].name), 2);
  const energies = rows(byId("energies"), [...model.energies.map((e) => e.name), "total"], 1);
  let largest = 0; // J, of all energies since the start

  const show = () => {
    const { q, u, t } = simulator;
    const outputs = simulator.outputs();
    angles.forEach(([value, rate], i) => {
      value.textContent = shown(q[i], model.coordinates[i].unit);
      if (isPaired(i)) rate.textContent = shown(u[i], model.rates[i].unit);
    });
    alone.forEach((i, row) => (others[row][1].textContent = shown(u[i], model.rates[i].unit)));
    const joules = [...outputs.energy, outputs.totalEnergy];
    largest = joules.reduce((most, value) => Math.max(most, Math.abs(value)), largest);
    prefixed(joules, "J", largest).forEach((text, i) => (energies[i][0].textContent = text));
    byId("time").textContent = t.toFixed(3);
    draw(outputs.pose);
  };
  const play = (wanted) => {
    playing = wanted;
    byId("play").textContent = playing ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", String(playing));
    if (playing) {
      last = performance.now();
      requestAnimationFrame(frame);
    }
  };
  // What stopped the run stays told until it is started again; what is wrong with a field is told beside the field.
  const attempt = (work) => {
    try {
      work();
      byId("problem").textContent = "";
    } catch (error) {
      byId("problem").textContent = `Stopped at t = ${simulator?.t.toFixed(3) ?? 0} s: ${error.reason ?? error.message}`;
      play(false);
    }
  };
  const frame = (now) => {
    if (!playing) return;
    const passed = Math.min(Math.max((now - last) / 1e3, 0), LONGEST_FRAME);
    last = now;
    attempt(() => {
      if (passed > 0) simulator.step(simulator.t + passed * Number(byId("speed").value));
      show();
    });
    if (playing) requestAnimationFrame(frame);
  };
  const restart = () =>
    attempt(() => {
      const fresh = model.create({ parameters: chosen.parameters });
      fresh.setInputs(chosen.inputs);
      simulator?.free();
      simulator = fresh;
      view.box = null;
      largest = 0;
      show();
    });
  const setting = (kind, apply) => (field, value) => {
    apply({ [field]: value });
    chosen[kind][field] = value;
    show();
  };

  if (model.inputs.length > 0) {
    byId("inputs").append(Object.assign(document.createElement("h2"), { textContent: "Inputs", style: "font-size:1rem;margin:0" }));
  }
  fields(byId("inputs"), model.inputs, setting("inputs", (values) => simulator.setInputs(values)));
  fields(byId("parameters"), model.parameters, setting("parameters", (values) => simulator.setParameters(values)));
  byId("play").addEventListener("click", () => play(!playing));
  byId("again").addEventListener("click", restart);
  byId("named").checked = view.named;
  byId("named").addEventListener("change", () => {
    [view.named, view.box] = [byId("named").checked, null];
    show();
  });
  legend();
  looking(show, () => play(!playing));
  window.addEventListener("resize", show);
  restart();
  const at = Number(new URLSearchParams(location.hash.slice(1)).get("t")); // index.html#t=1.5 shows that instant, at rest
  attempt(() => {
    if (at > 0) simulator.step(at);
    show();
  });
  // Those who asked their system for less motion start it themselves.
  play(!(at > 0) && !window.matchMedia("(prefers-reduced-motion: reduce)").matches);
}

/** Which colour is which body */
function legend() {
  for (const { name, colour, moving } of SHAPE.bodies) {
    const entry = document.createElement("li");
    const patch = Object.assign(document.createElement("span"), { className: "patch" });
    patch.style.background = `rgb(${colour.join(",")})`;
    entry.append(patch, `${name}${moving < 0 ? " (fixed)" : ""}`);
    byId("legend").append(entry);
  }
}

/** Pointer and keys turn the view. */
function looking(show, toggle) {
  const turn = (azimuth, elevation) => {
    view.azimuth += azimuth;
    view.elevation = Math.min(90, Math.max(-90, view.elevation + elevation));
    view.box = null;
    show();
  };
  const zoom = (factor) => {
    view.zoom = Math.min(50, Math.max(0.02, view.zoom * factor));
    show();
  };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) turn(-0.5 * event.movementX, 0.5 * event.movementY);
  });
  const keys = {
    ArrowLeft: () => turn(-5, 0),
    ArrowRight: () => turn(5, 0),
    ArrowUp: () => turn(0, 5),
    ArrowDown: () => turn(0, -5),
    "+": () => zoom(1.25),
    "-": () => zoom(0.8),
    " ": toggle,
  };
  canvas.addEventListener("keydown", (event) => {
    if (!Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key]();
  });
}

main().catch((error) => {
  byId("problem").textContent = error.message;
});
