const EYE = { azimuth: 30, elevation: 25 };

/** The picture of one device or plate: a canvas, names of hinges, a scale, and the axes of the world */
class Stage {
  /** home: { centre, radius, azimuth, elevation, wanders } */
  constructor(shape, home, label) {
    Object.assign(this, { shape, home, named: false, follows: home.wanders });
    this.canvas = el("canvas", { className: "view", tabIndex: 0, role: "img", "aria-label": label });
    this.names = el("div", { className: "names", "aria-hidden": "true" });
    this.marks = svg("svg", { class: "marks", "aria-hidden": "true" });
    this.element = el("div", { className: "stage" }, this.canvas, this.names, this.marks);
    this.draw = perFrame(() => this.paint());
    this.camera = new Camera(home, () => this.draw());
    this.poses = new Float64Array(12 * shape.bodies.length);
    shape.bodies.forEach((_, b) => this.poses.set(STILL, 12 * b));
    try {
      this.painter = new Painter(this.canvas, shape);
    } catch (error) {
      console.info(error.message);
      const canvas = this.canvas.cloneNode();
      this.canvas.replaceWith(canvas);
      this.canvas = canvas;
      this.painter = new FlatPainter(canvas, shape);
      this.element.append(el("p", { className: "plain", textContent: "This browser has no WebGL 2: no shadows, and lines are drawn over bodies." }));
    }
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.painter = new Painter(this.canvas, shape);
      this.draw();
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    const spans = shape.hinges.map((h) => norm(minus(h.ends.slice(3), h.ends.slice(0, 3)))).sort((a, b) => a - b);
    this.hingeLength = spans[spans.length >> 1] ?? 0;
    this.labels = shape.hinges.map((hinge) => el("span", { textContent: short(hinge.name, 20) }));
    this.bodyLabels = shape.bodies.map((body) => {
      const label = el("span", { className: "body" }, el("i"), short(body.name, 20));
      label.firstChild.style.background = body.colour;
      return label;
    });
    this.frames = [];
  }

  pose(body) {
    return this.poses.subarray(12 * body, 12 * body + 12);
  }

  /** The middle of what moves: a camera that follows looks at it */
  centre() {
    const free = this.shape.bodies.map((body, b) => [body, b]).filter(([body]) => !body.fixed);
    const all = free.length > 0 ? free : this.shape.bodies.map((body, b) => [body, b]);
    return times(1 / Math.max(all.length, 1), all.reduce((sum, [body, b]) => plus(sum, placed(this.pose(b), body.com)), [0, 0, 0]));
  }

  paint() {
    fitted(this.canvas);
    const { width, height } = this.canvas;
    if (width < 2 || height < 2) return;
    const began = performance.now();
    const ratio = ratioOf();
    this.camera.follow = this.follows ? minus(this.centre(), this.home.middle) : [0, 0, 0];
    const look = this.camera.look(width, height, ratio);
    look.bold = clamp((this.hingeLength / look.metre / ratio) / 40, 0.6, 1.25);
    look.fine = clamp(this.hingeLength / look.metre / ratio / 12, 0.5, 1);
    this.painter.draw(this.poses, look, this.planes(look));
    this.overlay(look, width / ratio, height / ratio, ratio);
    this.frames.push(performance.now() - began);
    if (this.frames.length > 600) this.frames.shift();
  }

  /** The ground where the scene has one, else a shadow on what would be the floor */
  planes(look) {
    const dark = isDark();
    const tint = dark ? { sheet: [0.14, 0.16, 0.2], ink: [0.36, 0.4, 0.48], dark: 0.5 } : { sheet: [0.93, 0.942, 0.957], ink: [0.66, 0.69, 0.74], dark: 0.24 };
    const { radius } = this.home;
    const real = this.shape.planes.map(({ point, normal }) => ({ point, normal, solid: 1 }));
    const all = real.length > 0 || this.home.floor === null ? real : [{ point: [look.target[0], look.target[1], this.home.floor], normal: [0, 0, 1], solid: 0 }];
    return all.map(({ point, normal, solid }) => {
      const along = unit(minus(Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], times(normal[0] * (Math.abs(normal[0]) < 0.9 ? 1 : 0) + (Math.abs(normal[0]) < 0.9 ? 0 : normal[1]), normal)));
      const across = cross(normal, along);
      const below = plus(point, times(-0.002 * radius, normal));
      const foot = minus(look.target, below);
      const [x, y] = [dot(foot, along), dot(foot, across)];
      const origin = plus(below, plus(times(x, along), times(y, across)));
      const cell = roundUp(radius / 6);
      return { ...tint, origin, along, across, far: radius * (solid ? 4.5 : 2.2), cell, shift: [x % cell, y % cell], solid };
    });
  }

  overlay(look, width, height, ratio) {
    const { view } = look;
    const seen = (p) => {
      const [x, y, , w] = [0, 1, 2, 3].map((r) => view[r] * p[0] + view[4 + r] * p[1] + view[8 + r] * p[2] + view[12 + r]);
      return [((x / w + 1) / 2) * width, ((1 - y / w) / 2) * height];
    };
    if (this.named) {
      this.shape.hinges.forEach((hinge, k) => {
        const middle = times(0.5, plus(hinge.ends.slice(0, 3), hinge.ends.slice(3)));
        const [x, y] = seen(placed(this.pose(hinge.parent), middle));
        this.labels[k].style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -130%)`;
      });
      this.shape.bodies.forEach((body, b) => {
        const [x, y] = seen(placed(this.pose(b), body.com));
        this.bodyLabels[b].style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
      });
    }
    const pixel = look.metre * ratio; // m, at the target
    const power = 10 ** Math.floor(Math.log10((width / 6) * pixel));
    const length = power * [5, 2, 1].find((step) => step * power <= (width / 6) * pixel);
    const wide = length / pixel;
    const [right, up] = look.axes;
    const origin = [width - 46, height - 40];
    const arms = [0, 1, 2].map((k) => [26 * right[k], -26 * up[k]]);
    const key = [width, height, wide, ...arms.flat()].map((x) => x.toFixed(1)).join();
    if (key === this.drawn) return;
    this.drawn = key;
    this.marks.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.marks.replaceChildren(
      svg("path", { d: `M14 ${height - 22}v6h${wide}v-6`, class: "scale" }),
      svg("text", { x: 14 + wide / 2, y: height - 24, "text-anchor": "middle" }, `${Number((length * 1e3).toPrecision(3))} mm`),
      ...arms.flatMap(([x, y], k) => [
        svg("line", { x1: origin[0], y1: origin[1], x2: origin[0] + x, y2: origin[1] + y, class: `axis-${"xyz"[k]}` }),
        svg("text", { x: origin[0] + 1.32 * x, y: origin[1] + 1.32 * y + 4, "text-anchor": "middle" }, "xyz"[k]),
      ]),
    );
  }

  name(shown) {
    this.named = shown;
    this.names.replaceChildren(...(shown ? [...this.bodyLabels, ...this.labels] : []));
    this.draw();
  }
}

/** A ball around points that a visitor is called with, about the middle of their box */
function ballOf(visit) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  visit((p) => {
    for (let k = 0; k < 3; k++) [low[k], high[k]] = [Math.min(low[k], p[k]), Math.max(high[k], p[k])];
  });
  if (!(high[0] >= low[0])) return { centre: [0, 0, 0], radius: 1, low: [0, 0, 0], high: [0, 0, 0] };
  const centre = times(0.5, plus(low, high));
  let radius = 0;
  visit((p) => (radius = Math.max(radius, norm(minus(p, centre)))));
  return { centre, radius: radius || 1, low, high };
}
