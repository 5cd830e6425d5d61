const NOTHING = { bodies: [], hinges: [], planes: [], mesh: { points: [], triangles: [], bodies: [] }, edges: { points: [], bodies: [] }, sticks: { points: [], bodies: [] } };

/** A plate: a surface that bends under its loads or swings in its modes, and what colours it */
class Plate {
  constructor(data, player) {
    Object.assign(this, { data, player, events: [], time: 0, scale: 1, shape: data.shapes[0], field: data.shapes[0].fields[0] });
    const count = data.points.length / 2;
    const ball = ballOf((visit) => {
      for (let k = 0; k < count; k++) visit([data.points[2 * k], data.points[2 * k + 1], 0]);
    });
    const floor = -0.24 * ball.radius * 1.5;
    const home = { centre: ball.centre, middle: ball.centre, radius: 1.04 * ball.radius, wanders: false, floor, ...data.view };
    this.stage = new Stage({ ...NOTHING, size: 2 * ball.radius }, home, data.description);
    this.places = new Float32Array(3 * count);
    const corners = data.corners.length;
    this.triangles = this.makeTriangles(corners, data.perCell);
    this.surface = {
      points: new Float32Array(3 * corners), normals: new Float32Array(3 * corners), colours: new Uint8Array(4 * corners).fill(255),
      triangles: this.triangles, rim: this.rim(count),
    };
    this.side = el("div", { className: "side" });
    const label = data.label ? [el("h2", { textContent: data.label })] : [];
    this.element = el("article", { className: "show" }, ...label, el("div", { className: "pair" }, this.stage.element, this.side));
    this.makeSide();
    this.choose(0);
  }

  /** Corners of cells as triangles; those of four corners are split in two */
  makeTriangles(count, perCell) {
    if (perCell === 3) return Uint32Array.from({ length: count }, (_, k) => k);
    const order = [0, 1, 2, 0, 2, 3];
    return Uint32Array.from({ length: 1.5 * count }, (_, k) => 4 * Math.floor(k / 6) + order[k % 6]);
  }

  /** Ends of the rim's lines as corners of cells */
  rim(count) {
    const first = new Int32Array(count).fill(-1);
    this.data.corners.forEach((p, k) => first[p] < 0 && (first[p] = k));
    return Array.from(this.data.rim, (p) => first[p]);
  }

  makeSide() {
    const { shapes } = this.data;
    this.which = el("select", { "aria-label": "what moves", onchange: () => this.choose(Number(this.which.value)) });
    this.which.append(...shapes.map((shape, k) => el("option", { value: String(k), textContent: short(shape.name, 60) })));
    this.what = el("select", { "aria-label": "colour", onchange: () => this.colour(Number(this.what.value)) });
    this.scaled = new Slider({ name: "deflections, times", value: 1, least: 0.01, most: 100, log: true }, (value) => {
      this.factor = value;
      this.seek(this.time);
    });
    this.bar = el("canvas", { width: 256, height: 1, role: "img", "aria-label": "colours, from the least to the largest" });
    [this.low, this.high] = [el("span"), el("span")];
    this.ends = el("p", { className: "hint" });
    const line = (name, field) => el("label", { className: "row" }, name, field);
    this.side.append(
      line("Shown", this.which), line("Coloured by", this.what), el("div", { className: "scalebar" }, this.low, this.bar, this.high), this.ends, this.scaled.element,
    );
  }

  choose(k) {
    this.shape = this.data.shapes[k];
    const { factor } = this.shape;
    this.factor = factor;
    const range = { value: factor, start: factor, least: factor / 20, most: factor * 20 };
    Object.assign(this.scaled, range);
    this.scaled.put(factor);
    this.what.replaceChildren(...this.shape.fields.map((field, i) => el("option", { value: String(i), textContent: field.name })));
    const same = this.shape.fields.findIndex((field) => field.name === this.field.name);
    this.what.value = String(Math.max(same, 0));
    this.colour(Math.max(same, 0));
  }

  colour(k) {
    const field = (this.field = this.shape.fields[k]);
    const table = this.data.maps[field.colours];
    const { colours } = this.surface;
    this.data.corners.forEach((p, c) => {
      const level = field.levels[field.jumps ? c : p];
      for (let i = 0; i < 3; i++) colours[4 * c + i] = table[3 * level + i];
    });
    const pen = this.bar.getContext("2d");
    const image = pen.createImageData(256, 1);
    for (let level = 0; level < 256; level++) image.data.set([table[3 * level], table[3 * level + 1], table[3 * level + 2], 255], 4 * level);
    pen.putImageData(image, 0, 0);
    const [factor, unit] = displayOf(field.unit, Math.max(Math.abs(field.low), Math.abs(field.high)));
    const tell = (x) => `${Number((x * factor).toPrecision(4))} ${unit}`.replace("-", "−");
    [this.low.textContent, this.high.textContent] = [tell(field.low), tell(field.high)];
    this.ends.textContent = `least ${tell(field.least)}, largest ${tell(field.most)}`;
    this.seek(this.time);
  }

  /** A mode swings; a load comes and goes */
  share(time) {
    const turn = (2 * Math.PI * time) / (this.data.duration || 1);
    return this.shape.swings ? Math.sin(turn) : (1 - Math.cos(turn)) / 2;
  }

  seek(time) {
    this.time = time;
    const { triangles } = this;
    const { points, corners } = this.data;
    const { moved, step } = this.shape;
    const { places, surface } = this;
    const share = this.data.duration > 0 ? this.share(time) * this.factor * step : 0;
    for (let p = 0; p < places.length / 3; p++) {
      places[3 * p] = points[2 * p] + share * moved[3 * p];
      places[3 * p + 1] = points[2 * p + 1] + share * moved[3 * p + 1];
      places[3 * p + 2] = share * moved[3 * p + 2];
    }
    const normals = new Float32Array(places.length);
    for (let k = 0; k < triangles.length; k += 3) {
      const [a, b, c] = [corners[triangles[k]], corners[triangles[k + 1]], corners[triangles[k + 2]]];
      const [ux, uy, uz] = [places[3 * b] - places[3 * a], places[3 * b + 1] - places[3 * a + 1], places[3 * b + 2] - places[3 * a + 2]];
      const [vx, vy, vz] = [places[3 * c] - places[3 * a], places[3 * c + 1] - places[3 * a + 1], places[3 * c + 2] - places[3 * a + 2]];
      const [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (const p of [a, b, c]) {
        normals[3 * p] += nx;
        normals[3 * p + 1] += ny;
        normals[3 * p + 2] += nz;
      }
    }
    corners.forEach((p, k) => {
      for (let i = 0; i < 3; i++) {
        surface.points[3 * k + i] = places[3 * p + i];
        surface.normals[3 * k + i] = normals[3 * p + i];
      }
    });
    this.stage.painter.setSurface(surface);
    this.stage.draw();
  }

  tellTime(time) {
    const share = Math.round(100 * this.share(time));
    return this.shape.swings ? `${share} %`.replace("-", "−") : `load ${share} %`;
  }

  tell() {}
}
