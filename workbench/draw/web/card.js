// What lives on the graphics card: programs, buffers and how a frame is painted with them.
// All of it can be made again from the arrays of the scene, as after the loss of a context.

import { LINE, MARK, MESH, SPHERE } from "./shaders.js";

const VEIL = 0.42; // opacity of walls that stand before a body
const GLASS = 0.22;

export class Card {
  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    this.build();
  }

  // Everything that lives on the graphics card, from the arrays that are kept here.
  build() {
    const { gl, scene } = this;
    this.programs = {};
    for (const [name, source] of Object.entries({ SPHERE, MESH, LINE, MARK })) {
      this.programs[name] = program(gl, source);
    }
    this.people = scene.bodies.map((body) => this.buildBody(body));
    this.faces = this.lines = null;
    if (scene.place) {
      const { vertices, part, triangles, edges } = scene.place;
      this.faces = this.buildMesh(vertices, part, triangles);
      this.lines = this.buildMesh(vertices, part, edges);
      this.parts = gl.createTexture();
    }
    this.marks = { vao: gl.createVertexArray(), buffer: gl.createBuffer(), count: 0 };
    gl.bindVertexArray(this.marks.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.marks.buffer);
    for (let k = 0; k < 3; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 36, 12 * k);
      gl.vertexAttribDivisor(k, 1);
    }
    this.framed = null;
  }

  attribute(place, array, size, type, { normal = false, each = 0, whole = false } = {}) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    if (whole) gl.vertexAttribIPointer(place, size, type, 0, 0);
    else gl.vertexAttribPointer(place, size, type, normal, 0, 0);
    gl.vertexAttribDivisor(place, each);
    return buffer;
  }

  buildBody(body) {
    const { gl } = this;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    const at = this.attribute(0, body.centres, 3, gl.FLOAT, { each: 1 });
    const radius = this.attribute(1, body.radius, 1, gl.FLOAT, { each: 1 });
    const tint = this.attribute(2, body.tint, 4, gl.UNSIGNED_BYTE, { normal: true, each: 1 });
    return { vao, at, radius, tint };
  }

  buildMesh(vertices, part, index) {
    const { gl } = this;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    this.attribute(0, vertices, 3, gl.FLOAT);
    this.attribute(1, Uint16Array.from(part), 1, gl.UNSIGNED_SHORT, { whole: true });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { vao, count: index.length };
  }

  // Colours, opacity and displacement of the parts, after one was hidden or the theme changed.
  setParts(shown, dim) {
    const { gl, scene } = this;
    if (!scene.place) return;
    const { parts } = scene.place;
    const looks = new Float32Array(8 * parts.length);
    parts.forEach((part, k) => {
      const colour = part.colour.map((c) => (c / 255) * dim);
      const opacity = !shown.part(k) ? 0 : part.glass ? GLASS : 1;
      looks.set([...colour, opacity, ...(part.shift || [0, 0, 0]), 0], 8 * k);
    });
    gl.bindTexture(gl.TEXTURE_2D, this.parts);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 2, parts.length, 0, gl.RGBA, gl.FLOAT, looks);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  // One frame as a viewer has it: camera, section, theme, what is shown.
  paint(viewer) {
    const { gl, scene } = this;
    const { width, height } = viewer.canvas;
    const matrices = viewer.camera.matrices();
    const plane = viewer.section ? inView(viewer.section, matrices.view) : [0, 0, 0, -1];
    const use = (name) => {
      const { made, at } = this.programs[name];
      gl.useProgram(made);
      gl.uniformMatrix4fv(at.view, false, matrices.view);
      gl.uniformMatrix4fv(at.proj, false, matrices.proj);
      if (at.section) gl.uniform4fv(at.section, plane);
      if (at.parts) gl.bindTexture(gl.TEXTURE_2D, this.parts);
      return at;
    };
    gl.viewport(0, 0, width, height);
    gl.clearColor(...viewer.look.paper, 1);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    // bodies leave a one in the stencil: there, walls that stand before them are a veil
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.ALWAYS, 1, 1);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    const sphere = use("SPHERE");
    scene.bodies.forEach((body, k) => {
      if (viewer.shown.body(k)) this.paintBody(sphere, body, k);
    });
    this.framed = scene.frame;
    if (this.faces) this.paintPlace(use, viewer);
    gl.disable(gl.STENCIL_TEST);
    if (viewer.through) this.paintThrough(use("SPHERE"), viewer.through);
    if (this.marks.count) {
      const at = use("MARK");
      gl.uniform2f(at.size, width, height);
      gl.uniform1f(at.width, viewer.strokes);
      gl.disable(gl.DEPTH_TEST);
      gl.bindVertexArray(this.marks.vao);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.marks.count);
    }
  }

  paintBody(at, body, k) {
    const { gl } = this;
    gl.uniform1i(at.ghost, body.ghost ? 1 : 0);
    gl.bindVertexArray(this.people[k].vao);
    if (this.framed !== this.scene.frame) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.people[k].at);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, body.centres);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.people[k].tint);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, body.tint);
    }
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, body.radius.length);
  }

  // Spheres of a body, from one to another of each range, through whatever hides them: every other pixel.
  paintThrough(at, { body, ranges }) {
    const { gl } = this;
    const { vao, at: centres, radius, tint } = this.people[body];
    const from = (first) => {
      const place = (slot, buffer, size, type, normal, bytes) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.vertexAttribPointer(slot, size, type, normal, 0, bytes * first);
      };
      place(0, centres, 3, gl.FLOAT, false, 12);
      place(1, radius, 1, gl.FLOAT, false, 4);
      place(2, tint, 4, gl.UNSIGNED_BYTE, true, 4);
    };
    gl.disable(gl.BLEND);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.uniform1i(at.ghost, 1);
    gl.bindVertexArray(vao);
    for (const [first, last] of ranges) {
      from(first);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, last - first);
    }
    from(0);
  }

  paintPlace(use, { walls, look }) {
    const { gl } = this;
    const mesh = use("MESH");
    const faces = (pass) => {
      gl.uniform1i(mesh.pass, pass);
      gl.drawElements(gl.TRIANGLES, this.faces.count, gl.UNSIGNED_INT, 0);
    };
    gl.uniform1f(mesh.veil, VEIL);
    gl.bindVertexArray(this.faces.vao);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    gl.stencilFunc(walls ? gl.ALWAYS : gl.EQUAL, 0, 1);
    faces(0);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    if (!walls) {
      gl.stencilFunc(gl.EQUAL, 1, 1);
      faces(2);
    }
    gl.stencilFunc(gl.ALWAYS, 0, 1);
    const line = use("LINE");
    gl.uniform4fv(line.ink, look.ink);
    gl.bindVertexArray(this.lines.vao);
    gl.drawElements(gl.LINES, this.lines.count, gl.UNSIGNED_INT, 0);
    gl.useProgram(this.programs.MESH.made);
    gl.bindVertexArray(this.faces.vao);
    faces(1);
    gl.depthMask(true);
  }

  // Lines from point to point: [{ from, to, colour }].
  setMarks(lines) {
    const { gl } = this;
    const flat = lines.flatMap(({ from, to, colour }) => [...from, ...to, ...colour.map((c) => c / 255)]);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.marks.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(flat), gl.DYNAMIC_DRAW);
    this.marks.count = lines.length;
  }
}

// A plane [a, b, c, d] of the world in view coordinates.
function inView([a, b, c, d], v) {
  const n = [0, 1, 2].map((row) => v[row] * a + v[4 + row] * b + v[8 + row] * c);
  return [...n, d - (n[0] * v[12] + n[1] * v[13] + n[2] * v[14])];
}

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(gl.getProgramInfoLog(made));
  }
  const at = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const { name } = gl.getActiveUniform(made, k);
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}
