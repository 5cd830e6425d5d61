const PALETTE = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00"];
const DASHES = [[], [7, 4], [7, 3, 2, 3], [2, 3]];
const SHOWN = 8; // curves at first, of more: those that change most

/** Curves over time with a cursor, and a legend that tells their values there. They may still be growing. */
class Curves {
  /** specs: { name, unit, at }, at: place among the motion's curves; seek: called with an instant */
  constructor(title, specs, seek) {
    Object.assign(this, { title, seek, motion: null, time: 0, from: 0, duration: 1, events: [], cursor: null });
    this.lines = specs.map((spec, k) => ({ ...spec, on: true, colour: PALETTE[k % 6], dash: DASHES[Math.floor(k / 6) % 4] }));
    this.canvas = el("canvas", { className: "plot", tabIndex: 0, role: "img", "aria-label": `${title} over time; the list beside tells the values at the cursor` });
    this.list = el("ul", { className: "legend" });
    this.lines.forEach((line) => this.list.append(this.entry(line)));
    this.head = el("h3", { textContent: title });
    this.element = el("section", { className: "curves" }, this.head, el("div", { className: "frame" }, this.canvas), this.list);
    this.draw = perFrame(() => this.paint());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    const go = (event) => {
      const box = this.canvas.getBoundingClientRect();
      this.seek(clamp((event.clientX - box.left - this.left) / (this.wide || 1), 0, 1) * (this.duration - this.from) + this.from);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons & 1 && go(event));
  }

  entry(line) {
    line.value = el("output", {});
    const toggle = el("button", {
      type: "button", "aria-pressed": "true", title: line.name,
      onclick: () => {
        line.on = !line.on;
        toggle.setAttribute("aria-pressed", String(line.on));
        this.draw();
      },
    });
    line.toggle = toggle;
    line.path = svg("path", { d: "M1 5h20", stroke: line.colour, "stroke-dasharray": line.dash.join(" ") });
    const mark = svg("svg", { viewBox: "0 0 22 10", class: "mark" }, line.path);
    toggle.append(mark, el("span", { className: "name", textContent: short(line.name) }), line.value);
    return el("li", {}, toggle);
  }

  /** Another motion; its rows may not all be there */
  show(motion, duration, events, from = 0) {
    Object.assign(this, { motion, duration, events, from });
    this.measure();
    this.part();
    if (!this.chosen && this.lines.length > SHOWN && motion.filled > 1) {
      this.chosen = true;
      const most = [...this.lines].sort((a, b) => b.high - b.low - (a.high - a.low)).slice(0, SHOWN);
      this.lines.forEach((line) => {
        line.on = most.includes(line);
        line.toggle.setAttribute("aria-pressed", String(line.on));
      });
    }
    this.draw();
  }

  /** Extremes of what has come since the last time */
  measure() {
    for (const line of this.lines) {
      const values = this.motion.curves[line.at];
      if (line.of !== this.motion) Object.assign(line, { of: this.motion, seen: 0, low: Infinity, high: -Infinity });
      line.seen = Math.min(line.seen, Math.max(this.motion.filled - 1, 0)); // a motion may have forgotten rows
      for (; line.seen < this.motion.filled; line.seen++) {
        const value = values[line.seen];
        if (value < line.low) line.low = value;
        if (value > line.high) line.high = value;
      }
    }
  }

  /** Lines that lie on one another get dashes, so that all of them are seen */
  part() {
    if (this.motion === this.parted || this.motion.filled < 2 || this.lines.length > 24) return;
    this.parted = this.motion.filled === this.motion.rows ? this.motion : null;
    const instants = Array.from({ length: 40 }, (_, k) => (this.motion.end * k) / 39);
    const [low, high] = this.range();
    const values = this.lines.map((line) => instants.map((t) => this.motion.curve(line.at, t)));
    const same = (a, b) => values[a].every((v, i) => Math.abs(v - values[b][i]) < 0.004 * (high - low));
    this.lines.forEach((line, k) => {
      const before = this.lines.slice(0, k).filter((_, j) => same(j, k)).length;
      line.dash = before > 0 ? [12 - 3 * Math.min(before, 3), 6 + 4 * Math.min(before, 3)] : DASHES[Math.floor(k / 6) % 4];
      line.path.setAttribute("stroke-dasharray", line.dash.join(" "));
    });
  }

  range() {
    const shown = this.lines.filter((line) => line.on && line.high >= line.low);
    let [low, high] = [Math.min(...shown.map((l) => l.low)), Math.max(...shown.map((l) => l.high))];
    if (!(high >= low)) [low, high] = [0, 1];
    const span = high - low || Math.abs(high) * 1e-3 || 1;
    return [low - 0.06 * span, high + 0.06 * span];
  }

  paint() {
    fitted(this.canvas);
    const pen = this.canvas.getContext("2d");
    const ratio = ratioOf();
    const [width, height] = [this.canvas.width / ratio, this.canvas.height / ratio];
    if (this.motion === null || width < 40) return;
    const style = getComputedStyle(this.canvas);
    const [ink, faint] = [style.getPropertyValue("--ink"), style.getPropertyValue("--line")];
    const [low, high] = this.range();
    const largest = Math.max(Math.abs(low), Math.abs(high));
    const [factor, unit] = displayOf(this.lines[0].unit, largest);
    this.head.textContent = unit === "" ? this.title : `${this.title}, ${unit}`;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "11px system-ui, sans-serif";
    const rows = ticks(low * factor, high * factor, Math.max(2, height / 38));
    const texts = rows.at.map((y) => fixed(y, rows.step));
    this.left = 10 + Math.max(...texts.map((text) => pen.measureText(text).width));
    this.wide = width - this.left - 8;
    const tall = height - 24;
    const x = (t) => this.left + ((t - this.from) / (this.duration - this.from)) * this.wide;
    const y = (value) => 6 + (1 - (value - low) / (high - low)) * (tall - 6);
    pen.lineWidth = 1;
    pen.strokeStyle = faint;
    pen.fillStyle = ink;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.beginPath();
    rows.at.forEach((value, k) => {
      const place = Math.round(y(value / factor)) + 0.5;
      pen.moveTo(this.left, place);
      pen.lineTo(width - 8, place);
      pen.fillText(texts[k], this.left - 5, place);
    });
    pen.textAlign = "center";
    const columns = ticks(this.from, this.duration, Math.max(2, this.wide / 90));
    columns.at.forEach((t, k) => {
      const last = k === columns.at.length - 1;
      const text = `${fixed(t, columns.step)}${last ? " s" : ""}`;
      pen.fillText(text, Math.min(x(t), width - 2 - pen.measureText(text).width / 2), height - 7);
      pen.moveTo(Math.round(x(t)) + 0.5, 6);
      pen.lineTo(Math.round(x(t)) + 0.5, tall);
    });
    pen.stroke();
    this.eventLines(pen, x, tall);
    pen.save();
    pen.beginPath();
    pen.rect(this.left, 0, this.wide + 1, tall + 1);
    pen.clip();
    for (const line of this.lines) if (line.on) this.line(pen, line, x, y);
    pen.restore();
    this.mark(pen, x, y, tall, ink, factor, high - low);
  }

  eventLines(pen, x, tall) {
    if (this.events.length === 0) return;
    const few = this.events.length <= 24; // many are short marks below the curves
    pen.strokeStyle = few ? "rgba(213, 94, 0, 0.5)" : "rgba(213, 94, 0, 0.8)";
    if (few) pen.setLineDash([2, 3]);
    pen.beginPath();
    let last = -1;
    for (const [t] of this.events) {
      const place = Math.round(x(t)) + 0.5;
      if (place === last) continue;
      last = place;
      pen.moveTo(place, few ? 6 : tall - 5);
      pen.lineTo(place, tall);
    }
    pen.stroke();
    pen.setLineDash([]);
  }

  line(pen, { at, colour, dash }, x, y) {
    const { t, filled } = this.motion;
    const values = this.motion.curves[at];
    pen.strokeStyle = isDark() ? lighter(colour) : colour;
    pen.lineWidth = 1.8;
    pen.lineJoin = "round";
    pen.setLineDash(dash);
    pen.beginPath();
    for (let i = this.motion.at(this.from)[0]; i < filled; i++) pen.lineTo(x(t[i]), y(values[i]));
    pen.stroke();
    pen.setLineDash([]);
  }

  mark(pen, x, y, tall, ink, factor, span) {
    const place = x(clamp(this.time, this.from, this.duration));
    pen.strokeStyle = ink;
    pen.lineWidth = 1.2;
    pen.beginPath();
    pen.moveTo(place, 4);
    pen.lineTo(place, tall);
    pen.stroke();
    for (const line of this.lines) {
      const value = this.motion.curve(line.at, this.time);
      const text = fixed(value * factor, (span * factor) / 2000);
      if (line.text !== text) line.value.textContent = line.text = text;
      if (!line.on || !Number.isFinite(value)) continue;
      pen.fillStyle = isDark() ? lighter(line.colour) : line.colour;
      pen.beginPath();
      pen.arc(place, y(value), 3.4, 0, 7);
      pen.fill();
    }
  }

  at(time) {
    this.time = time;
    this.draw();
  }
}

/** Of a colour, one for dark paper */
function lighter(colour) {
  return `rgb(${rgb(colour).map((c) => Math.round(c + 0.32 * (255 - c))).join(",")})`;
}
