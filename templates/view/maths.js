const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => times(1 / (norm(a) || 1), a);
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// A pose is 12 numbers, three rows of [R | s]: a point x as drawn is at R x + s.
const STILL = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
const placed = (pose, x) => [0, 4, 8].map((k) => pose[k] * x[0] + pose[k + 1] * x[1] + pose[k + 2] * x[2] + pose[k + 3]);
const turned = (pose, x) => [0, 4, 8].map((k) => pose[k] * x[0] + pose[k + 1] * x[1] + pose[k + 2] * x[2]);

/** First one pose, then the other */
function after(second, first) {
  const out = new Array(12);
  for (let r = 0; r < 12; r += 4) {
    for (let c = 0; c < 4; c++) {
      out[r + c] = second[r] * first[c] + second[r + 1] * first[4 + c] + second[r + 2] * first[8 + c];
    }
    out[r + 3] += second[r + 3];
  }
  return out;
}

/** A turn by `angle` about the line through `point` along the unit vector `axis` (Rodrigues) */
function turnAbout(point, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [x, y, z] = axis;
  const v = 1 - c;
  const pose = [
    c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0,
    y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0,
    z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0,
  ];
  const moved = turned(pose, point);
  for (let k = 0; k < 3; k++) pose[4 * k + 3] = point[k] - moved[k];
  return pose;
}

/** The pose that takes a body from its centre as drawn to `centre`, turned by the quaternion (w, x, y, z) */
function poseOf(out, place, drawn, cx, cy, cz, w, x, y, z) {
  const s = 2 / (w * w + x * x + y * y + z * z || 1);
  const rows = [
    1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y),
    s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x),
    s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y),
  ];
  const centre = [cx, cy, cz];
  for (let k = 0; k < 3; k++) {
    const [a, b, c] = [rows[3 * k], rows[3 * k + 1], rows[3 * k + 2]];
    out[place + 4 * k] = a;
    out[place + 4 * k + 1] = b;
    out[place + 4 * k + 2] = c;
    out[place + 4 * k + 3] = centre[k] - a * drawn[0] - b * drawn[1] - c * drawn[2];
  }
}

/** (w, x, y, z) of a rotation by rows, as `lamc.view.recording.quaternions` */
function quaternion(m, place = 0) {
  const at = (k) => m[place + k];
  const squares = [
    1 + at(0) + at(4) + at(8), 1 + at(0) - at(4) - at(8), 1 - at(0) + at(4) - at(8), 1 - at(0) - at(4) + at(8),
  ];
  const [a, b, c] = [at(7) - at(5), at(2) - at(6), at(3) - at(1)];
  const [d, e, f] = [at(1) + at(3), at(2) + at(6), at(5) + at(7)];
  const best = squares.indexOf(Math.max(...squares));
  const found = [[squares[0], a, b, c], [a, squares[1], d, e], [b, d, squares[2], f], [c, e, f, squares[3]]][best];
  const size = Math.hypot(...found);
  return found.map((x) => x / size);
}

// --- matrices of drawing: 4 by 4, column by column, as WebGL takes them -----------------------------------------------

function product(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    }
  }
  return out;
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  const d = near - far;
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) / d, -1, 0, 0, (2 * near * far) / d, 0]);
}

function parallel(half, near, far) {
  const d = near - far;
  return new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, 2 / d, 0, 0, 0, (near + far) / d, 1]);
}

/** From the world to what an eye sees that looks at `target`: x right, y up, z towards it */
function lookAt(eye, right, up, towards) {
  const rows = [right, up, towards];
  const out = new Float32Array(16);
  rows.forEach((row, r) => {
    for (let c = 0; c < 3; c++) out[4 * c + r] = row[c];
    out[12 + r] = -dot(row, eye);
  });
  out[15] = 1;
  return out;
}

/** Right, up and towards the eye. Degrees, azimuth from the -y direction, as in lamc's other pictures. */
function axesOf({ azimuth, elevation }) {
  const [a, e] = [azimuth, elevation].map((angle) => (angle * Math.PI) / 180);
  const towards = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
  const right = [Math.cos(a), Math.sin(a), 0];
  return [right, cross(towards, right), towards];
}

// --- numbers for people -----------------------------------------------------------------------------------------------

/** The least of 1, 2, 5 times a power of ten that is not below x */
function roundUp(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [1, 2, 5, 10].map((k) => k * power).find((y) => y >= x * (1 - 1e-9));
}

/** What numbers of a unit are shown in: factor and unit, by the largest of them */
function displayOf(name, largest) {
  if (name === "rad") return [180 / Math.PI, "°"];
  if (name === "rad/s") return [180 / Math.PI, "°/s"];
  if (name === "1" || name === "") return [1, ""];
  const metric = { m: "m", J: "J", Pa: "Pa", N: "N", s: "s", "N/m": "N/m", "m/s": "m/s" }[name];
  if (metric === undefined || !(largest > 0)) return [1, name];
  const steps = name === "m" || name === "m/s" ? [[1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]]
    : [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]];
  const [size, prefix] = steps.find(([step]) => largest >= 0.999 * step) ?? steps.at(-1);
  return [1 / size, `${prefix}${metric}`];
}

/** As many places after the point as tell numbers `step` apart */
function fixed(value, step) {
  if (!Number.isFinite(value)) return "–";
  const places = clamp(Math.ceil(-Math.log10(step || 1) - 1e-9), 0, 12);
  const text = value.toFixed(places);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Round marks within low … high, about `count` of them */
function ticks(low, high, count) {
  if (!(high > low)) return { step: 1, at: [low] };
  const raw = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= raw * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return { step, at: Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => (first + k) * step) };
}
