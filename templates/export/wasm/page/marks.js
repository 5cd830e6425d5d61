const INK = "rgb(213,94,0)"; // of hinges
// How far the arrow around a hinge goes, from the child's side on, rad
const ARC = Array.from({ length: 24 }, (_, k) => ((15 + 5 * k) * Math.PI) / 180);

/** Points of a hinge's arrows, m, world: along its axis, and around it as the child turns where the angle grows */
function hingeArrows(hinge, places) {
  const { size } = SHAPE;
  const [start, end] = hinge.ends.map(places[hinge.parent].point);
  const axis = places[hinge.parent].normal(hinge.axis);
  const out = places[hinge.child].normal(hinge.out);
  const across = cross(axis, out);
  const middle = start.map((x, i) => (x + end[i]) / 2);
  const half = Math.max(Math.hypot(...minus(end, start)) / 2, 0.05 * size);
  const on = (way) => middle.map((x, i) => x + way * axis[i]);
  const centre = on(0.4 * half);
  const radius = 0.055 * size;
  return {
    along: [on(-half), on(half + 0.05 * size)],
    around: ARC.map((a) => centre.map((x, i) => x + radius * (Math.cos(a) * out[i] + Math.sin(a) * across[i]))),
  };
}

/** A line with a head at its end, in pixels; bodies may have the ink's colour, so it has a white rim */
function arrow(points, colour, ratio) {
  const [x, y] = points.at(-1);
  const [fromX, fromY] = points.at(-2);
  const length = Math.hypot(x - fromX, y - fromY);
  const whole = Math.hypot(x - points[0][0], y - points[0][1]);
  pen.beginPath();
  points.forEach((p, i) => (i === 0 ? pen.moveTo(p[0], p[1]) : pen.lineTo(p[0], p[1])));
  if (length > 1e-3 && whole > 3 * ratio) {
    const [along, across] = [(x - fromX) / length, (y - fromY) / length];
    const head = 7 * ratio;
    for (const side of [-0.45, 0.45]) {
      pen.moveTo(x, y);
      pen.lineTo(x - head * (along - side * across), y - head * (across + side * along));
    }
  }
  for (const [style, line] of [["rgba(255,255,255,0.85)", 4.5], [colour, 1.8]]) {
    pen.strokeStyle = style;
    pen.lineWidth = line * ratio;
    pen.stroke();
  }
}

/** Texts, each beside its point where none of those before it lies; last resort: over them */
function labels(wanted, width, height, ratio) {
  pen.font = `${12 * ratio}px system-ui, sans-serif`;
  pen.textBaseline = "middle";
  const taken = [];
  for (const { text, place: [x, y] } of wanted) {
    const [w, h] = [pen.measureText(text).width + 6 * ratio, 16 * ratio];
    const gap = 5 * ratio;
    const corners = [0, 1, 2].flatMap((k) => [
      [x + gap, y - gap - h - k * h], [x + gap, y + gap + k * h],
      [x - gap - w, y - gap - h - k * h], [x - gap - w, y + gap + k * h],
    ]).map(([left, top]) => [Math.min(Math.max(left, 0), width - w), Math.min(Math.max(top, 0), height - h)]);
    const isFree = ([left, top]) =>
      taken.every(([l, t, r, b]) => left >= r || left + w <= l || top >= b || top + h <= t);
    const [left, top] = corners.find(isFree) ?? corners[0];
    taken.push([left, top, left + w, top + h]);
    pen.fillStyle = "rgba(255,255,255,0.8)";
    pen.fillRect(left, top, w, h);
    pen.fillStyle = "#222";
    pen.fillText(text, left + 3 * ratio, top + h / 2);
  }
}

/** Below the mechanism: a length of 1, 2 or 5 times a power of ten, about a seventh of the picture's width ... */
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
  pen.textBaseline = "alphabetic";
  pen.fillText(`${Number((length * 1e3).toPrecision(3))} mm`, x, y - 6 * ratio);
}

/** ... and the directions of the world's axes */
function triad([right, up], width, height, ratio) {
  const length = 24 * ratio;
  const ways = [0, 1, 2].map((k) => [length * right[k], -length * up[k]]);
  const [low, high] = [0, 1].map((i) => extent([0, ...ways.map((way) => way[i])])).reduce(
    ([l, h], [a, b]) => [[...l, a], [...h, b]], [[], []]);
  const origin = [width - 44 * ratio - (low[0] + high[0]) / 2, height - STRIP * ratio * 0.5 - (low[1] + high[1]) / 2];
  pen.font = `${12 * ratio}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  ways.forEach((way, k) => {
    const tip = origin.map((x, i) => x + way[i]);
    arrow([origin, tip], "#333", ratio);
    const far = Math.max(Math.hypot(...way), 1e-9);
    pen.fillStyle = "#222";
    pen.fillText("xyz"[k], ...tip.map((x, i) => x + (far < 3 * ratio ? 9 * ratio : (9 * ratio * way[i]) / far)));
  });
  pen.textAlign = "start";
}
