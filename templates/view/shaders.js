// Poses lie in a texture, three texels (the rows of [R | s]) for each body; its last row is the world.
const PLACE = `#version 300 es
precision highp float;
uniform highp sampler2D poses;
uniform mat4 view;
vec4 row(float body, int k) { return texelFetch(poses, ivec2(k, int(body + 0.5)), 0); }
vec3 placed(vec3 p, float body) {
  vec4 q = vec4(p, 1.0);
  return vec3(dot(row(body, 0), q), dot(row(body, 1), q), dot(row(body, 2), q));
}
vec3 turned(vec3 p, float body) { return vec3(dot(row(body, 0).xyz, p), dot(row(body, 1).xyz, p), dot(row(body, 2).xyz, p)); }
`;
const SHADOW = `
uniform highp sampler2DShadow shadows;
uniform mat4 light;
uniform float soft;
float lit(vec3 world, float bias) {
  vec4 p = light * vec4(world, 1.0);
  vec3 s = p.xyz / p.w * 0.5 + 0.5;
  if (s.x < 0.0 || s.y < 0.0 || s.x > 1.0 || s.y > 1.0 || s.z > 1.0) return 1.0;
  float sum = 0.0;
  for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++)
    sum += texture(shadows, vec3(s.xy + vec2(i, j) * soft, s.z - bias));
  return sum / 25.0;
}
`;
const SHADERS = {
  body: [
    `${PLACE}
in vec3 point; in vec3 normal; in vec4 colour; in float body;
out vec3 world; out vec3 facing; out vec4 paint;
void main() {
  world = placed(point, body);
  facing = turned(normal, body);
  paint = colour;
  gl_Position = view * vec4(world, 1.0);
}`,
    `#version 300 es
precision highp float;
${SHADOW}
uniform vec3 eye; uniform vec3 sun; uniform float lift;
in vec3 world; in vec3 facing; in vec4 paint;
out vec4 shade;
void main() {
  vec3 n = normalize(facing), to = normalize(eye - world);
  if (dot(n, to) < 0.0) n = -n;
  float sunny = max(dot(n, sun), 0.0);
  float open = sunny > 0.0 ? lit(world + n * lift, 0.0012) : 0.0;
  float sky = 0.5 + 0.5 * n.z;
  float bright = 0.54 + 0.12 * sky + 0.12 * max(dot(n, to), 0.0) + 0.34 * sunny * open;
  float gloss = pow(max(dot(n, normalize(sun + to)), 0.0), 40.0) * 0.16 * open;
  shade = vec4(paint.rgb * bright + gloss, 1.0);
}`,
  ],
  depth: [
    `${PLACE}
in vec3 point; in float body;
void main() { gl_Position = view * vec4(placed(point, body), 1.0); }`,
    `#version 300 es
precision mediump float;
void main() {}`,
  ],
  // Lines as strips of a width in pixels, a little nearer to the eye than they are
  line: [
    `${PLACE}
in vec2 corner; in vec3 from; in vec3 to; in float body; in float reach; in vec4 colour;
uniform vec3 eye; uniform vec2 pixels; uniform float wide; uniform float nearer;
out vec4 paint;
vec4 seen(vec3 p) {
  vec3 world = placed(p, body);
  return view * vec4(world + normalize(eye - world) * (nearer + reach), 1.0);
}
void main() {
  vec4 a = seen(from), b = seen(to);
  a.w = max(a.w, 1e-6); b.w = max(b.w, 1e-6);
  vec2 way = (b.xy / b.w - a.xy / a.w) * pixels;
  way = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
  vec4 p = corner.x < 0.5 ? a : b;
  vec2 aside = vec2(-way.y, way.x) * corner.y + way * (corner.x * 2.0 - 1.0) * 0.5;
  p.xy += aside * wide / pixels * p.w;
  gl_Position = p;
  paint = colour;
}`,
    `#version 300 es
precision mediump float;
in vec4 paint;
out vec4 shade;
void main() { shade = vec4(paint.rgb * paint.a, paint.a); }`,
  ],
  ground: [
    `#version 300 es
precision highp float;
uniform mat4 view; uniform vec3 origin; uniform vec3 along; uniform vec3 across; uniform float far;
in vec2 corner;
out vec3 world; out vec2 flat_;
void main() {
  flat_ = (corner * 2.0 - 1.0) * far;
  world = origin + along * flat_.x + across * flat_.y;
  gl_Position = view * vec4(world, 1.0);
}`,
    `#version 300 es
precision highp float;
${SHADOW}
uniform float far; uniform float cell; uniform vec3 sheet; uniform vec3 ink; uniform float solid; uniform vec2 shift;
uniform float dark;
in vec3 world; in vec2 flat_;
out vec4 shade;
void main() {
  float fade = 1.0 - smoothstep(0.45, 1.0, length(flat_) / far);
  vec2 place = (flat_ + shift) / cell, slope = fwidth(place);
  vec2 near = abs(fract(place - 0.5) - 0.5) / max(slope, vec2(1e-6));
  float line = (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.15, 0.5, max(slope.x, slope.y)));
  float shadow = (1.0 - lit(world, 0.0008)) * dark;
  vec3 colour = mix(sheet, ink, line * 0.55 * solid);
  colour = mix(colour, vec3(0.05, 0.07, 0.12), shadow);
  float alpha = fade * max(max(solid * 0.92, line * solid), shadow * (1.0 - 0.0));
  shade = vec4(colour * alpha, alpha);
}`,
  ],
};
