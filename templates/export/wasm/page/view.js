const canvas = byId("view");
const pen = canvas.getContext("2d");
const view = { azimuth: SHAPE.azimuth, elevation: SHAPE.elevation, zoom: 1, box: null, named: SHAPE.hinges.length <= 8 };
const STRIP = 72; // pixels of the page, below the mechanism, for scale and axes
const LOWEST = 300; // pixels of the page: a narrow page has a picture that is taller than wide
const MOST_RATIO = 2; // pixels of the picture by one of the page: finer screens cost time and show nothing more

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
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
  return [right, cross(towards, right), towards];
}

/** What there is to draw, m: points along the frame's axes */
function sceneOf(poses, frame) {
  const places = SHAPE.bodies.map((body) => placer(body, poses));
  const look = (world) => frame.map((axis) => dot(axis, world));
  const of = (body) => (p) => look(places[body].point(p));
  const faces = SHAPE.faces.flatMap(([body, drawn, rings]) => {
    const n = look(places[body].normal(drawn));
    if (n[2] <= 1e-6) return [];
    const shade = 0.62 + 0.38 * Math.min(1, Math.max(0, -0.35 * n[0] + 0.55 * n[1] + 0.76 * n[2]));
    const colour = SHAPE.bodies[body].colour.map((c) => Math.round(c * shade));
    return [{ rings: rings.map((ring) => ring.map(of(body))), slopes: [-n[0] / n[2], n[1] / n[2]], colour }];
  });
  const hinges = SHAPE.hinges.map((hinge) => {
    const { along, around } = hingeArrows(hinge, places);
    return { name: hinge.name, along: along.map(look), around: around.map(look) };
  });
  const sticks = SHAPE.sticks.map(([body, ends]) => ({ colour: SHAPE.bodies[body].colour, ends: ends.map(of(body)) }));
  return { faces, edges: SHAPE.edges.map(([body, ends]) => ends.map(of(body))), sticks, hinges };
}

/** All that was seen since the view last changed stays in the picture: it does not swing with the mechanism. */
function boxOf({ faces, sticks, hinges }) {
  const box = view.box ?? [Infinity, -Infinity, Infinity, -Infinity];
  const groups = [
    ...faces.flatMap((face) => face.rings),
    ...sticks.map((stick) => stick.ends),
    ...(view.named ? hinges.flatMap((hinge) => [hinge.along, hinge.around]) : hinges.map((hinge) => hinge.along)),
  ];
  for (const [x, y] of groups.flat()) {
    view.box = box;
    [box[0], box[1]] = [Math.min(box[0], x), Math.max(box[1], x)];
    [box[2], box[3]] = [Math.min(box[2], y), Math.max(box[3], y)];
  }
  return view.box ?? [-1, 1, -1, 1];
}

let buffer = null;

function draw(poses) {
  const ratio = Math.min(window.devicePixelRatio || 1, MOST_RATIO);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.round(Math.max(width * 0.66, LOWEST * ratio));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const tall = height - Math.round(STRIP * ratio);
  if (buffer?.width !== width || buffer.height !== tall) buffer = new DepthBuffer(width, tall);
  const frame = axes();
  const scene = sceneOf(poses, frame);
  const [left, right, low, high] = boxOf(scene);
  const least = 0.05 * SHAPE.size;
  const [free, above] = [width - (view.named ? 80 : 30) * ratio, tall - (view.named ? 56 : 20) * ratio];
  const scale = view.zoom * Math.min(free / Math.max(right - left, least), above / Math.max(high - low, least));
  const seen = (p) => [
    width / 2 + scale * (p[0] - (left + right) / 2),
    tall / 2 - scale * (p[1] - (low + high) / 2),
    scale * p[2],
  ];
  paint(scene, seen, ratio);
  scaleBar(scale, height, ratio);
  triad(frame, width, height, ratio);
}

function paint({ faces, edges, sticks, hinges }, seen, ratio) {
  pen.clearRect(0, 0, canvas.width, canvas.height);
  buffer.clear();
  for (const face of faces) buffer.fill(face.rings.map((ring) => ring.map(seen)), face.slopes, face.colour);
  pen.putImageData(buffer.image, 0, 0);
  pen.save();
  pen.beginPath();
  pen.rect(0, 0, buffer.width, buffer.height);
  pen.clip();
  pen.lineJoin = pen.lineCap = "round";
  const strokes = (list, colour, line) => {
    pen.beginPath();
    for (const ends of list) buffer.trace(pen, ends.map(seen), 0.75 * ratio);
    pen.strokeStyle = colour;
    pen.lineWidth = line * ratio;
    pen.stroke();
  };
  const nearness = ({ ends: [a, b] }) => a[2] + b[2];
  for (const { ends, colour } of sticks.sort((a, b) => nearness(a) - nearness(b))) {
    strokes([ends], `rgb(${colour.join(",")})`, 5);
  }
  strokes(edges, "rgb(40,40,40)", 1.2);
  const wanted = [];
  for (const { name, along, around } of hinges) {
    arrow(along.map(seen), INK, ratio);
    if (view.named) arrow(around.map(seen), INK, ratio);
    wanted.push({ text: name.length > 20 ? `${name.slice(0, 19)}…` : name, place: seen(along[1]) });
  }
  if (view.named) labels(wanted, buffer.width, buffer.height, ratio);
  pen.restore();
}
