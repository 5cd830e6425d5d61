/**
 * A motion as rows: instants t, centres (3) and quaternions (4) of the b moving bodies, and curves. Rows may still be
 * coming: `filled` of them are there.
 */
class Motion {
  constructor(bodies, curves, rows) {
    [this.bodies, this.rows, this.filled] = [bodies, rows, 0];
    this.t = new Float64Array(rows);
    this.centres = new Float64Array(3 * bodies * rows);
    this.turns = new Float64Array(4 * bodies * rows);
    this.curves = Array.from({ length: curves }, () => new Float64Array(rows));
  }

  /** What `recording.py` made */
  static recorded({ t, centres, turns, curves }) {
    const [c, q, v] = [centres, turns, curves].map(lengthened);
    const bodies = c.length / 3;
    const motion = new Motion(bodies, 0, t.length);
    motion.t.set(t);
    c.forEach((column, k) => column.forEach((x, i) => (motion.centres[3 * bodies * i + k] = x)));
    q.forEach((column, k) => column.forEach((x, i) => (motion.turns[4 * bodies * i + k] = x)));
    [motion.curves, motion.filled] = [v, t.length];
    return motion;
  }

  /** A row of a model in the page; curves: values in their order */
  append(t, poses, curves) {
    const i = this.filled;
    this.t[i] = t;
    poses.forEach((pose, b) => {
      const place = 3 * (this.bodies * i + b);
      for (let k = 0; k < 3; k++) this.centres[place + k] = pose[k];
      const turn = quaternion(pose, 3);
      const [now, before] = [4 * (this.bodies * i + b), 4 * (this.bodies * (i - 1) + b)];
      const same = i === 0 || turn.reduce((sum, x, k) => sum + x * this.turns[before + k], 0) >= 0;
      turn.forEach((x, k) => (this.turns[now + k] = same ? x : -x));
    });
    curves.forEach((x, c) => (this.curves[c][i] = x));
    this.filled += 1;
  }

  /** Makes room for more rows where there is none: the older half goes */
  forget() {
    if (this.filled < this.rows) return;
    const half = this.rows >> 1;
    const keep = (array, width) => array.copyWithin(0, width * half, width * this.rows);
    keep(this.t, 1);
    keep(this.centres, 3 * this.bodies);
    keep(this.turns, 4 * this.bodies);
    this.curves.forEach((values) => keep(values, 1));
    this.filled = this.rows - half;
  }

  get end() {
    return this.filled > 0 ? this.t[this.filled - 1] : 0;
  }

  /** The row before an instant, and how far on the way to the next it is */
  at(time) {
    let [low, high] = [0, this.filled - 1];
    if (high < 1 || time <= this.t[0]) return [0, 0];
    if (time >= this.t[high]) return [high - 1, 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.t[middle] <= time) low = middle;
      else high = middle;
    }
    const span = this.t[high] - this.t[low];
    return [low, span > 0 ? (time - this.t[low]) / span : 1];
  }

  /** Poses, 12 numbers each, of the bodies `moving` of a shape; drawn: centres as drawn */
  poses(time, moving, drawn, out) {
    if (this.filled === 0) return out;
    const [i, share] = this.at(time);
    const j = Math.min(i + 1, this.filled - 1);
    const { bodies, centres, turns } = this;
    moving.forEach((body, b) => {
      const [c, d] = [3 * (bodies * i + b), 3 * (bodies * j + b)];
      const [p, r] = [4 * (bodies * i + b), 4 * (bodies * j + b)];
      const mix = (row, from, to, k) => row[from + k] + share * (row[to + k] - row[from + k]);
      poseOf(
        out, 12 * body, drawn[body],
        mix(centres, c, d, 0), mix(centres, c, d, 1), mix(centres, c, d, 2),
        mix(turns, p, r, 0), mix(turns, p, r, 1), mix(turns, p, r, 2), mix(turns, p, r, 3),
      );
    });
    return out;
  }

  curve(index, time) {
    const values = this.curves[index];
    if (this.filled === 0) return NaN;
    const [i, share] = this.at(time);
    return values[i] + share * (values[Math.min(i + 1, this.filled - 1)] - values[i]);
  }
}
