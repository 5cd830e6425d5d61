const SHADOWS = 1536; // texels along a side of the shadow map

/** Draws bodies, lines and planes by WebGL 2. Throws where there is none. */
class Painter {
  constructor(canvas, shape) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
    if (gl === null) throw new Error("no WebGL 2");
    Object.assign(this, { canvas, gl, shape });
    this.programs = Object.fromEntries(Object.entries(SHADERS).map(([name, texts]) => [name, this.program(...texts)]));
    this.bodies = shape.bodies.length;
    this.table = new Float32Array(12 * (this.bodies + 1));
    this.table.set(STILL, 12 * this.bodies);
    this.poses = this.texture(gl.RGBA32F, 3, this.bodies + 1, gl.RGBA, gl.FLOAT);
    this.makeShadows();
    this.quad = this.buffer(new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]));
    this.square = this.buffer(new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]));
    this.mesh = this.makeMesh(shape.mesh, shape.bodies.map((body) => rgb(body.colour)));
    this.lines = {
      edges: this.makeLines(shape.edges.points, shape.edges.bodies, null, () => [40, 40, 46, 190]),
      sticks: this.makeLines(shape.sticks.points, shape.sticks.bodies, null, (k) => [...rgb(shape.bodies[shape.sticks.bodies[k]].colour), 255]),
      hinges: this.makeLines(
        Float32Array.from(shape.hinges.flatMap((h) => h.ends)), shape.hinges.map((h) => h.parent), shape.hinges.map((h) => Math.min(2.5 * h.reach, 0.03 * shape.size)),
        () => [...HINGE, 255],
      ),
    };
    this.surface = null;
  }

  program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].forEach(([kind, text]) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      const [shader] = gl.getAttachedShaders(program).map((each) => gl.getShaderInfoLog(each)).filter(Boolean);
      throw new Error(`WebGL: ${shader ?? gl.getProgramInfoLog(program)}`);
    }
    const names = (count, get, locate) =>
      Object.fromEntries(Array.from({ length: count }, (_, k) => get(k).name).map((name) => [name, locate(name)]));
    return {
      program,
      at: names(gl.getProgramParameter(program, gl.ACTIVE_ATTRIBUTES), (k) => gl.getActiveAttrib(program, k), (n) => gl.getAttribLocation(program, n)),
      set: names(gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS), (k) => gl.getActiveUniform(program, k), (n) => gl.getUniformLocation(program, n)),
    };
  }

  texture(inside, width, height, format, type) {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, format, type, null);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    return texture;
  }

  makeShadows() {
    const gl = this.gl;
    this.shadows = this.texture(gl.DEPTH_COMPONENT24, SHADOWS, SHADOWS, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    this.room = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.room);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadows, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  buffer(data, usage = this.gl.STATIC_DRAW) {
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, data, usage);
    return buffer;
  }

  /** Flat triangles, each with corners of its own */
  makeMesh({ points, triangles, bodies }, colours) {
    const count = triangles.length;
    const [place, normal] = [new Float32Array(3 * count), new Float32Array(3 * count)];
    const [colour, body] = [new Uint8Array(4 * count), new Float32Array(count)];
    for (let k = 0; k < count; k += 3) {
      const [a, b, c] = [0, 1, 2].map((i) => Array.from(points.subarray(3 * triangles[k + i], 3 * triangles[k + i] + 3)));
      const n = unit(cross(minus(b, a), minus(c, a)));
      const owner = bodies[k / 3];
      [a, b, c].forEach((p, i) => {
        place.set(p, 3 * (k + i));
        normal.set(n, 3 * (k + i));
        colour.set([...colours[owner], 255], 4 * (k + i));
        body[k + i] = owner;
      });
    }
    return { count, point: this.buffer(place), normal: this.buffer(normal), colour: this.buffer(colour), body: this.buffer(body) };
  }

  makeLines(points, bodies, reach, colour) {
    const count = bodies.length;
    const tints = Uint8Array.from(Array.from({ length: count }, (_, k) => colour(k)).flat());
    return {
      count, ends: this.buffer(Float32Array.from(points)), body: this.buffer(Float32Array.from(bodies)),
      reach: this.buffer(Float32Array.from(reach ?? new Float32Array(count))), colour: this.buffer(tints),
    };
  }

  /** A surface whose points move: smooth normals and colours, corner by corner */
  setSurface({ points, normals, colours, triangles, rim }) {
    const gl = this.gl;
    if (this.surface === null) {
      this.surface = { count: triangles.length, body: this.buffer(new Float32Array(points.length / 3).fill(this.bodies)), index: gl.createBuffer(), rim: rim.length / 2 };
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.surface.index);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
      for (const part of ["point", "normal", "colour"]) this.surface[part] = gl.createBuffer();
      this.lines.rim = this.makeLines(new Float32Array(3 * rim.length), new Uint16Array(rim.length / 2).fill(this.bodies), null, () => [30, 30, 36, 255]);
    }
    for (const [part, data] of [["point", points], ["normal", normals], ["colour", colours]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.surface[part]);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    }
    const ends = new Float32Array(3 * rim.length);
    rim.forEach((p, k) => ends.set(points.subarray(3 * p, 3 * p + 3), 3 * k));
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lines.rim.ends);
    gl.bufferData(gl.ARRAY_BUFFER, ends, gl.DYNAMIC_DRAW);
  }

  /** Attributes by name: [buffer, numbers, type, stride, first byte, per instance] */
  bind({ at }, attributes) {
    const gl = this.gl;
    for (const [name, [buffer, size, type = gl.FLOAT, stride = 0, first = 0, each = 0]] of Object.entries(attributes)) {
      if (!(name in at)) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(at[name]);
      gl.vertexAttribPointer(at[name], size, type, type === gl.UNSIGNED_BYTE, stride, first);
      gl.vertexAttribDivisor(at[name], each);
    }
  }

  use(name, uniforms) {
    const gl = this.gl;
    const program = this.programs[name];
    gl.useProgram(program.program);
    for (const [key, value] of Object.entries(uniforms)) {
      const where = program.set[key];
      if (where === undefined) continue;
      if (value.length === 16) gl.uniformMatrix4fv(where, false, value);
      else if (value.length === 3) gl.uniform3fv(where, value);
      else if (value.length === 2) gl.uniform2fv(where, value);
      else gl.uniform1f(where, value);
    }
    if (program.set.poses !== undefined) gl.uniform1i(program.set.poses, 0);
    if (program.set.shadows !== undefined) gl.uniform1i(program.set.shadows, 1);
    return program;
  }

  solids(name, uniforms) {
    const gl = this.gl;
    const program = this.use(name, uniforms);
    for (const mesh of [this.mesh, this.surface]) {
      if (mesh === null || mesh.count === 0) continue;
      this.bind(program, { point: [mesh.point, 3], normal: [mesh.normal, 3], colour: [mesh.colour, 4, gl.UNSIGNED_BYTE], body: [mesh.body, 1] });
      if (mesh === this.surface) {
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.index);
        gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
      } else gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
    }
  }

  strokes(lines, wide, nearer, uniforms) {
    if (lines === undefined || lines.count === 0) return;
    const gl = this.gl;
    const program = this.use("line", { ...uniforms, wide, nearer });
    this.bind(program, {
      corner: [this.quad, 2], from: [lines.ends, 3, gl.FLOAT, 24, 0, 1], to: [lines.ends, 3, gl.FLOAT, 24, 12, 1],
      body: [lines.body, 1, gl.FLOAT, 0, 0, 1], reach: [lines.reach, 1, gl.FLOAT, 0, 0, 1], colour: [lines.colour, 4, gl.UNSIGNED_BYTE, 0, 0, 1],
    });
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.count);
    for (const name of ["from", "to", "body", "reach", "colour"]) if (name in program.at) gl.vertexAttribDivisor(program.at[name], 0);
  }

  /** One picture. poses: 12 numbers for each body; look: what `Camera.look` gives; planes: what `Stage` shows as ground */
  draw(poses, look, planes) {
    const gl = this.gl;
    const { canvas } = this;
    this.table.set(poses.length > 12 * this.bodies ? poses.subarray(0, 12 * this.bodies) : poses);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.poses);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 3, this.bodies + 1, gl.RGBA, gl.FLOAT, this.table);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    const light = this.shade(look);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.shadows);
    const { view, eye, radius, ratio } = look;
    const common = { view, eye, light, sun: look.sun, soft: 1.1 / SHADOWS, lift: radius * 0.004, pixels: [canvas.width / 2, canvas.height / 2] };
    this.solids("body", common);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    for (const plane of planes) this.ground(plane, common);
    this.strokes(this.lines.sticks, 2.4 * ratio, 0, common);
    this.strokes(this.lines.edges, 0.55 * ratio * look.fine, radius * 0.0015, common);
    this.strokes(this.lines.rim, 0.8 * ratio, radius * 0.0015, common);
    this.strokes(this.lines.hinges, look.bold * ratio, radius * 0.003, common);
  }

  /** The depths that the sun sees; gives its matrix */
  shade({ sun, target, radius }) {
    const gl = this.gl;
    const right = unit(cross([0, 0, 1], sun));
    const eye = plus(target, times(2 * radius, sun));
    const light = product(parallel(1.25 * radius, 0.1 * radius, 4.5 * radius), lookAt(eye, right, cross(sun, right), sun));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.room);
    gl.viewport(0, 0, SHADOWS, SHADOWS);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(2, 4);
    this.solids("depth", { view: light });
    gl.disable(gl.POLYGON_OFFSET_FILL);
    return light;
  }

  ground({ origin, along, across, far, cell, shift, sheet, ink, solid, dark }, common) {
    const gl = this.gl;
    const normal = cross(along, across);
    if (dot(normal, minus(common.eye, origin)) <= 0) return; // nothing from below
    gl.depthMask(false);
    const program = this.use("ground", { ...common, origin, along, across, far, cell, shift, sheet, ink, solid, dark });
    this.bind(program, { corner: [this.square, 2] });
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
  }
}
