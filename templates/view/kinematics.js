const CLOSED = 1e-10; // rad, and of the size: loops count as closed
const ROUNDS = 60;
const WIDEST = 0.06; // rad: a held angle goes no farther between two closings, so that the others keep their branch

/** Poses of a mechanism's bodies by its joints' angles, and the angles that close its loops */
class Kinematics {
  constructor({ size, bodies, hinges, tree }) {
    Object.assign(this, { size, hinges, tree });
    this.count = bodies.length;
    this.carrier = new Map(tree.links.map((link) => [link.body, link]));
  }

  /** Angles: one per hinge, in the mechanism's order; those of hinges that close loops are not read */
  poses(angles) {
    const poses = Array.from({ length: this.count }, () => STILL);
    for (const { joint, body, inner, sign } of this.tree.links) {
      const { point, axis } = this.hinges[joint];
      poses[body] = after(poses[inner], turnAbout(point, times(sign, axis), angles[joint]));
    }
    return poses;
  }

  /** What is left open at each cut hinge: turn between its sides (3), rad, and shift (3) over the size */
  gaps(angles, poses = this.poses(angles)) {
    const rows = [];
    for (const joint of this.tree.cuts) {
      const { parent, child, point, axis } = this.hinges[joint];
      const one = after(poses[parent], turnAbout(point, axis, angles[joint]));
      const other = poses[child];
      // The turn from one to the other, by the skew part of R_other R_oneᵀ
      const m = (r, c) => [0, 1, 2].reduce((sum, k) => sum + other[4 * r + k] * one[4 * c + k], 0);
      const [x, y, z] = [m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)].map((v) => v / 2);
      const shift = minus(placed(other, point), placed(one, point));
      rows.push(x, y, z, ...times(1 / this.size, shift));
    }
    return rows;
  }

  /** Joints between a body and the world, with the side on which the body is */
  path(body) {
    const path = [];
    for (let link = this.carrier.get(body); link; link = this.carrier.get(link.inner)) path.push(link);
    return path;
  }

  /** Derivatives of `gaps` by the angles: a row for each */
  slopes(poses) {
    const rows = [];
    for (const joint of this.tree.cuts) {
      const hinge = this.hinges[joint];
      const block = Array.from({ length: 6 }, () => new Float64Array(this.hinges.length));
      const place = placed(poses[hinge.child], hinge.point);
      const add = (index, carried, sign, axis, point) => {
        const along = times(sign, turned(carried, axis));
        const arm = times(1 / this.size, cross(along, minus(place, placed(carried, point))));
        for (let k = 0; k < 3; k++) {
          block[k][index] += along[k];
          block[3 + k][index] += arm[k];
        }
      };
      for (const [body, way] of [[hinge.child, 1], [hinge.parent, -1]]) {
        for (const { joint: index, inner, sign } of this.path(body)) {
          add(index, poses[inner], way * sign, this.hinges[index].axis, this.hinges[index].point);
        }
      }
      add(joint, poses[hinge.parent], -1, hinge.axis, hinge.point);
      rows.push(...block);
    }
    return rows;
  }

  /** The nearest angles that close all loops while those of `held` (a Set of hinges) stay; null where none are near */
  closed(angles, held) {
    if (this.tree.cuts.length === 0) return angles;
    const free = this.hinges.map((_, k) => k).filter((k) => !held.has(k));
    let now = Array.from(angles);
    let poses = this.poses(now);
    let open = this.gaps(now, poses);
    let error = Math.max(...open.map(Math.abs));
    let damping = 1e-9;
    for (let round = 0; round < ROUNDS && error > CLOSED; round++) {
      const step = leastSquares(this.slopes(poses), open, free, damping);
      const next = Array.from(now);
      free.forEach((k, i) => (next[k] -= clamp(step[i], -0.3, 0.3)));
      const [there, left] = [this.poses(next), null];
      const gaps = left ?? this.gaps(next, there);
      const worst = Math.max(...gaps.map(Math.abs));
      if (worst < error) {
        [now, poses, open, error] = [next, there, gaps, worst];
        damping = Math.max(damping / 10, 1e-12);
      } else {
        damping *= 100;
        if (damping > 1) break;
      }
    }
    return error <= 1e-7 ? now : null;
  }

  /** Rates of all hinges at closed angles: those that are given (null: is not), and the smallest others; and whether
   * that is a motion */
  rates(angles, given) {
    const free = given.flatMap((rate, k) => (rate === null ? [k] : []));
    const rates = given.map((rate) => rate ?? 0);
    const rows = this.slopes(this.poses(angles));
    const left = () => rows.map((row) => rates.reduce((sum, rate, k) => sum + row[k] * rate, 0));
    for (let round = 0; round < 2; round++) { // once more for the digits that the squares took
      const step = leastSquares(rows, left(), free, 1e-12);
      free.forEach((k, i) => (rates[k] -= step[i]));
    }
    const missed = Math.max(0, ...left().map(Math.abs));
    return { rates, fits: missed <= 1e-8 * Math.max(...given.map((rate) => Math.abs(rate ?? 0))) };
  }

  /** One hinge is turned to `angle`, in short steps; the others follow, or it stops where they cannot. `rates` is a way
   * out of a singular position, such as the flat one, by the rates of all hinges. */
  turnedTo(angles, joint, angle, rates = null) {
    let now = Array.from(angles);
    if (this.tree.cuts.length === 0) {
      now[joint] = angle;
      return now;
    }
    const count = Math.max(1, Math.ceil(Math.abs(angle - now[joint]) / WIDEST));
    const first = now[joint];
    let before = null;
    for (let k = 1; k <= count; k++) {
      const goal = first + ((angle - first) * k) / count;
      const by = goal - now[joint];
      const guess = now.map((x, i) => {
        if (i === joint) return goal;
        const last = before ? now[joint] - before[joint] : 0;
        if (Math.abs(last) > 1e-12) return x + ((now[i] - before[i]) / last) * by;
        return rates && Math.abs(rates[joint]) > 1e-9 ? x + (rates[i] / rates[joint]) * by : x;
      });
      const next = this.closed(guess, new Set([joint])) ?? this.closed(now.map((x, i) => (i === joint ? goal : x)), new Set([joint]));
      if (next === null) return now;
      [before, now] = [now, next];
    }
    return now;
  }
}

/** The least x with (AᵀA + damping) x = Aᵀ b, of the columns `free` of the rows of A (Levenberg), by Cholesky */
function leastSquares(rows, right, free, damping) {
  const n = free.length;
  const matrix = Array.from({ length: n }, () => new Float64Array(n));
  const x = new Float64Array(n);
  const entries = new Int32Array(n);
  rows.forEach((row, r) => {
    let count = 0;
    for (let i = 0; i < n; i++) if (row[free[i]] !== 0) entries[count++] = i;
    for (let p = 0; p < count; p++) {
      const i = entries[p];
      const value = row[free[i]];
      x[i] += value * right[r];
      for (let q = 0; q <= p; q++) matrix[i][entries[q]] += value * row[free[entries[q]]];
    }
  });
  const largest = matrix.reduce((most, row, i) => Math.max(most, row[i]), 1e-30);
  for (let i = 0; i < n; i++) matrix[i][i] += damping * largest;
  for (let i = 0; i < n; i++) {
    const row = matrix[i];
    for (let j = 0; j <= i; j++) {
      let sum = row[j];
      const other = matrix[j];
      for (let k = 0; k < j; k++) sum -= row[k] * other[k];
      row[j] = i === j ? Math.sqrt(Math.max(sum, 1e-300)) : sum / other[j];
    }
  }
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < i; k++) x[i] -= matrix[i][k] * x[k];
    x[i] /= matrix[i][i];
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) x[i] -= matrix[k][i] * x[k];
    x[i] /= matrix[i][i];
  }
  return x;
}
