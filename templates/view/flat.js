/** The same picture on a plain canvas, for browsers without WebGL: triangles from the farthest to the nearest, without
 * shadows. It has the methods of `Painter`. */
class FlatPainter {
  constructor(canvas, shape) {
    Object.assign(this, { canvas, shape, surface: null, pen: canvas.getContext("2d") });
    this.colours = shape.bodies.map((body) => rgb(body.colour));
  }

  setSurface(surface) {
    this.surface = surface;
  }

  draw(poses, { view, sun, ratio, bold }) {
    const { pen, canvas, shape } = this;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const pose = (b) => poses.slice(12 * b, 12 * b + 12);
    const seen = (p) => {
      const q = [0, 1, 2, 3].map((r) => view[r] * p[0] + view[4 + r] * p[1] + view[8 + r] * p[2] + view[12 + r]);
      return [((q[0] / q[3] + 1) / 2) * canvas.width, ((1 - q[1] / q[3]) / 2) * canvas.height, q[3]];
    };
    const at = (array, k) => [array[3 * k], array[3 * k + 1], array[3 * k + 2]];
    const items = [];
    const add = (corners, colour) => {
      const n = unit(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])));
      const bright = 0.66 + 0.34 * Math.abs(dot(n, sun));
      const points = corners.map(seen);
      items.push([points.reduce((sum, p) => sum + p[2], 0) / 3, points, colour.map((c) => Math.round(c * bright))]);
    };
    const { points, triangles, bodies } = shape.mesh;
    for (let k = 0; k < triangles.length; k += 3) {
      const body = bodies[k / 3];
      add([0, 1, 2].map((i) => placed(pose(body), at(points, triangles[k + i]))), this.colours[body]);
    }
    const surface = this.surface;
    for (let k = 0; surface !== null && k < surface.triangles.length; k += 3) {
      const corners = [0, 1, 2].map((i) => surface.triangles[k + i]);
      add(corners.map((p) => at(surface.points, p)), Array.from(surface.colours.subarray(4 * corners[0], 4 * corners[0] + 3)));
    }
    for (const [, corners, colour] of items.sort((a, b) => b[0] - a[0])) {
      pen.fillStyle = pen.strokeStyle = `rgb(${colour.join(",")})`;
      pen.beginPath();
      corners.forEach(([x, y], i) => (i === 0 ? pen.moveTo(x, y) : pen.lineTo(x, y)));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
    const line = (ends, body, colour, wide) => {
      pen.strokeStyle = colour;
      pen.lineWidth = wide * ratio;
      pen.beginPath();
      [at(ends, 0), at(ends, 1)].map((p) => seen(placed(pose(body), p))).forEach(([x, y], i) => (i === 0 ? pen.moveTo(x, y) : pen.lineTo(x, y)));
      pen.stroke();
    };
    shape.sticks.bodies.forEach((body, k) => line(shape.sticks.points.slice(6 * k), body, shape.bodies[body].colour, 5));
    shape.hinges.forEach((hinge) => line(hinge.ends, hinge.parent, `rgb(${HINGE.join(",")})`, bold));
  }
}
