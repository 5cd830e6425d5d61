const SAME = 1e-3; // pixels: of faces in one plane the first stays, where round-off would make a pattern of them

/**
 * Colours and depths of a picture's pixels: what lies nearer hides what lies behind it, pixel by pixel.
 * Points are [x, y, depth] in pixels, x to the right, y down; a greater depth is nearer to the viewer.
 */
class DepthBuffer {
  constructor(width, height) {
    this.image = new ImageData(width, height);
    this.colours = new Uint32Array(this.image.data.buffer);
    this.depths = new Float32Array(width * height);
    this.owners = new Int32Array(width * height); // 1 + place among the planes; 0: nothing
    this.planes = []; // [a, b, c]: depth = a x + b y + c
    [this.width, this.height] = [width, height];
  }

  clear() {
    this.colours.fill(0); // transparent
    this.depths.fill(-Infinity);
    this.owners.fill(0);
    this.planes = [];
  }

  /** A plane polygon, holes by the even-odd rule. slopes: of its depth along x and along y; colour: [r, g, b] */
  fill(rings, [alongX, alongY], [r, g, b]) {
    const word = ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
    const corners = rings.flat();
    const [x0, y0, z0] = corners[0];
    const owner = this.planes.push([alongX, alongY, z0 - alongX * x0 - alongY * y0]);
    // A face seen nearly from its edge is steep: within a pixel its plane would leave the face.
    const [farthest, nearest] = extent(corners.map((p) => p[2]));
    const [top, bottom] = extent(corners.map((p) => p[1]));
    const edges = rings.flatMap((ring) => ring.map((p, i) => [p, ring[(i + 1) % ring.length]]));
    const last = Math.min(this.height, Math.ceil(bottom - 0.5));
    for (let row = Math.max(0, Math.ceil(top - 0.5)); row < last; row++) {
      const y = row + 0.5;
      const cuts = edges
        .filter(([a, b]) => a[1] <= y !== b[1] <= y)
        .map(([a, b]) => a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0]))
        .sort((a, b) => a - b);
      const base = z0 + alongY * (y - y0) + alongX * (0.5 - x0);
      for (let k = 0; k + 1 < cuts.length; k += 2) {
        const end = Math.min(this.width, Math.ceil(cuts[k + 1] - 0.5));
        for (let column = Math.max(0, Math.ceil(cuts[k] - 0.5)); column < end; column++) {
          const depth = Math.min(nearest, Math.max(farthest, base + alongX * column));
          const place = row * this.width + column;
          if (depth <= this.depths[place] + SAME) continue;
          this.depths[place] = depth;
          this.colours[place] = word;
          this.owners[place] = owner;
        }
      }
    }
  }

  /**
   * Whether nothing filled hides a point. It is the plane at the point that counts, not the depth at the pixel's middle:
   * a line on the border of a steep face would else flicker.
   */
  isSeen([x, y, depth], slack) {
    const [column, row] = [Math.floor(x), Math.floor(y)];
    if (column < 0 || row < 0 || column >= this.width || row >= this.height) return true;
    const owner = this.owners[row * this.width + column];
    if (owner === 0) return true;
    const [a, b, c] = this.planes[owner - 1];
    return a * x + b * y + c <= depth + slack;
  }

  /** Adds the parts of a line that are seen to the pen's path. */
  trace(pen, [a, b], slack) {
    const [from, to] = this.within(a, b);
    if (from >= to) return;
    const at = (s) => a.map((x, i) => x + s * (b[i] - x));
    const count = Math.max(1, Math.ceil((to - from) * Math.max(Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1]))));
    let drawing = false;
    for (let k = 0; k <= count; k++) {
      const p = at(from + ((to - from) * k) / count);
      const seen = this.isSeen(p, slack);
      if (seen && drawing) pen.lineTo(p[0], p[1]);
      if (seen && !drawing) pen.moveTo(p[0], p[1]);
      drawing = seen;
    }
  }

  /** Which part of a line, from 0 to 1, lies in the picture (Liang and Barsky 1984); [1, 0]: none */
  within(a, b) {
    let [from, to] = [0, 1];
    for (const [axis, most] of [this.width, this.height].entries()) {
      const way = b[axis] - a[axis];
      if (way === 0) {
        if (a[axis] < 0 || a[axis] > most) return [1, 0];
        continue;
      }
      const [one, other] = [-a[axis] / way, (most - a[axis]) / way];
      from = Math.max(from, Math.min(one, other));
      to = Math.min(to, Math.max(one, other));
    }
    return [from, to];
  }
}

/** The least and the greatest of a row of numbers; a row may be too long for Math.min's arguments */
function extent(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return [low, high];
}
