const byId = (id) => document.getElementById(id);
const canvas = byId("view");
const pen = canvas.getContext("2d");
const view = { azimuth: SHAPE.azimuth, elevation: SHAPE.elevation, zoom: 1, box: null };
const LONGEST_FRAME = 0.05; // s: after a pause of the browser's the motion goes on, it does not jump

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const turned = (pose, v) => [0, 1, 2].map((i) => dot(pose.slice(3 + 3 * i, 6 + 3 * i), v));

/** From points as drawn, m, of a body to where they are now */
function placer(body, poses) {
  if (body.moving < 0) return { point: (p) => p, normal: (n) => n };
  const pose = poses[body.moving];
  return {
    point: (p) => turned(pose, minus(p, body.com)).map((x, i) => x + pose[i]),
    normal: (n) => turned(pose, n),
  };
}

/** Right, up and towards the viewer. Angles in degrees, azimuth from the -y direction. */
function axes() {
  const [a, e] = [view.azimuth, view.elevation].map((angle) => (angle * Math.PI) / 180);
  const towards = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
  const right = [Math.cos(a), Math.sin(a), 0];
  const up = [
    towards[1] * right[2] - towards[2] * right[1],
    towards[2] * right[0] - towards[0] * right[2],
    towards[0] * right[1] - towards[1] * right[0],
  ];
  return [right, up, towards];
}

function seen(shapes) {
  const box = view.box ?? [Infinity, -Infinity, Infinity, -Infinity];
  for (const [x, y] of shapes.flatMap((s) => s.points.flat())) {
    view.box = box;
    [box[0], box[1]] = [Math.min(box[0], x), Math.max(box[1], x)];
    [box[2], box[3]] = [Math.min(box[2], y), Math.max(box[3], y)];
  }
}

function draw(poses) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio);
  const height = Math.round(width * 0.66);
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const frame = axes();
  const places = SHAPE.bodies.map((body) => placer(body, poses));
  const look = (body, p) => {
    const world = places[body].point(p);
    return frame.map((axis) => dot(axis, world));
  };
  const shapes = [];
  for (const [body, normal, rings] of SHAPE.faces) {
    const n = places[body].normal(normal);
    if (dot(n, frame[2]) <= 1e-6) continue;
    const points = rings.map((ring) => ring.map((p) => look(body, p)));
    const light = -0.35 * dot(n, frame[0]) + 0.55 * dot(n, frame[1]) + 0.76 * dot(n, frame[2]);
    const shade = 0.62 + 0.38 * Math.min(1, Math.max(0, light));
    const fill = `rgb(${SHAPE.bodies[body].colour.map((c) => Math.round(c * shade)).join(",")})`;
    shapes.push({ points, fill, depth: middle(points[0]) });
  }
  const lines = (list, colour, line, above) => {
    for (const [body, ends] of list) {
      const points = [ends.map((p) => look(body, p))];
      const stroke = colour ?? `rgb(${SHAPE.bodies[body].colour.join(",")})`;
      shapes.push({ points, stroke, line, depth: middle(points[0]) + above });
    }
  };
  lines(SHAPE.sticks, null, 5, 0);
  lines(SHAPE.edges, "rgb(40,40,40)", 0.8, 0.01 * SHAPE.size);
  lines(SHAPE.hinges, "rgb(213,94,0)", 2, 1e3 * SHAPE.size);
  seen(shapes);
  paint(shapes.sort((a, b) => a.depth - b.depth), width, height, ratio);
}

const middle = (points) => points.reduce((sum, p) => sum + p[2], 0) / points.length;

function paint(shapes, width, height, ratio) {
  const [left, right, low, high] = view.box ?? [-1, 1, -1, 1];
  const least = 0.05 * SHAPE.size;
  const scale =
    0.9 * view.zoom * Math.min(width / Math.max(right - left, least), height / Math.max(high - low, least));
  const x = (p) => width / 2 + scale * (p[0] - (left + right) / 2);
  const y = (p) => height / 2 - scale * (p[1] - (low + high) / 2);
  pen.clearRect(0, 0, width, height);
  pen.lineJoin = pen.lineCap = "round";
  for (const shape of shapes) {
    pen.beginPath();
    for (const ring of shape.points) {
      ring.forEach((p, i) => (i === 0 ? pen.moveTo(x(p), y(p)) : pen.lineTo(x(p), y(p))));
      if (shape.fill) pen.closePath();
    }
    if (shape.fill) {
      pen.fillStyle = shape.fill;
      pen.fill("evenodd");
    } else {
      pen.strokeStyle = shape.stroke;
      pen.lineWidth = shape.line * ratio;
      pen.stroke();
    }
  }
  scaleBar(scale, height, ratio);
}

/** A length of 1, 2 or 5 times a power of ten, about a seventh of the picture's width */
function scaleBar(scale, height, ratio) {
  const wanted = canvas.width / 7 / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = power * [5, 2, 1].find((step) => step * power <= wanted);
  const [x, y] = [14 * ratio, height - 14 * ratio];
  pen.strokeStyle = pen.fillStyle = "#222";
  pen.lineWidth = 2 * ratio;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + length * scale, y);
  pen.stroke();
  pen.font = `${13 * ratio}px system-ui, sans-serif`;
  pen.fillText(`${Number((length * 1e3).toPrecision(3))} mm`, x, y - 6 * ratio);
}

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

function fields(parent, members, set) {
  for (const { field, name, unit, default: value } of members) {
    const label = document.createElement("label");
    const input = Object.assign(document.createElement("input"), { type: "number", step: "any", value });
    label.append(`${name}, ${unit}`, input);
    input.addEventListener("change", () => set(field, input));
    parent.append(label);
  }
}

async function main() {
  const model = await lamc[SHAPE.name].load();
  const chosen = { parameters: {}, inputs: {} };
  let simulator = null;
  let playing = false;
  let last = 0;

  const isAngle = (unit) => unit === "rad";
  const shown = (value, unit) => (isAngle(unit) ? `${((value * 180) / Math.PI).toFixed(2)}°` : `${value.toPrecision(5)}${unit === "1" ? "" : ` ${unit}`}`);
  const shownRate = (value, unit) => `${value.toPrecision(4)} ${unit}`;
  // The rates of a base that floats are no derivatives of its coordinates: they have rows of their own.
  const isPaired = (i) => i < model.rates.length && model.rates[i].name === model.coordinates[i]?.name;
  const alone = model.rates.map((_, i) => i).filter((i) => !isPaired(i));
  const angles = rows(byId("angles"), model.coordinates.map((c) => c.name), 2);
  const others = rows(byId("angles"), alone.map((i) => model.rates[i].name), 2);
  const energies = rows(byId("energies"), [...model.energies.map((e) => e.name), "total"], 1);

  const show = () => {
    const { q, u, t } = simulator;
    const outputs = simulator.outputs();
    angles.forEach(([value, rate], i) => {
      value.textContent = shown(q[i], model.coordinates[i].unit);
      if (isPaired(i)) rate.textContent = shownRate(u[i], model.rates[i].unit);
    });
    alone.forEach((i, row) => (others[row][1].textContent = shownRate(u[i], model.rates[i].unit)));
    [...outputs.energy, outputs.totalEnergy].forEach((value, i) => (energies[i][0].textContent = value.toExponential(6)));
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
  const attempt = (work) => {
    try {
      byId("problem").textContent = "";
      work();
    } catch (error) {
      byId("problem").textContent = error.message;
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
      show();
    });
  const setting = (kind, apply) => (field, input) =>
    attempt(() => {
      const value = input.value.trim() === "" ? NaN : Number(input.value);
      apply({ [field]: value });
      chosen[kind][field] = value;
    });

  if (model.inputs.length > 0) {
    byId("inputs").append(Object.assign(document.createElement("h2"), { textContent: "Inputs", style: "font-size:1rem;margin:0" }));
  }
  fields(byId("inputs"), model.inputs, setting("inputs", (values) => simulator.setInputs(values)));
  fields(byId("parameters"), model.parameters, setting("parameters", (values) => simulator.setParameters(values)));
  byId("play").addEventListener("click", () => play(!playing));
  byId("again").addEventListener("click", restart);
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
