// What lives on the graphics card: programs, buffers and how a frame is painted with them.
// All of it can be made again from the arrays of the scene, as after the loss of a context.

import { Over } from "./over.js";
import { inView, lineNumbers, program } from "./programs.js";
import { LINE, MARK, MESH, SPHERE } from "./shaders.js";
import { isOf, stripes } from "./wipe.js";

const VEIL = 0.42; // opacity of walls that stand before a body

export class Card {
  constructor(gl, scene) {
    Object.assign(this, { gl, scene, looks: [], lines: [] });
    this.over = new Over(this);
    this.build();
  }

  // Everything that lives on the graphics card, from what is kept here.
  build() {
    const { gl, scene } = this;
    this.programs = {};
    for (const [name, source] of Object.entries({ SPHERE, MESH, LINE, MARK })) {
      this.programs[name] = program(gl, source);
    }
    this.people = scene.bodies.map((body) => this.buildBody(body));
    this.faces = this.edges = null;
    if (scene.place) {
      const { vertices, part, triangles, edges } = scene.place;
      this.faces = this.buildMesh(vertices, part, triangles);
      this.edges = this.buildMesh(vertices, part, edges);
      this.parts = [0, 1].slice(0, scene.states ? 2 : 1).map(() => gl.createTexture());
    }
    this.marks = { vao: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(this.marks.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.marks.buffer);
    for (let k = 0; k < 3; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 36, 12 * k);
      gl.vertexAttribDivisor(k, 1);
    }
    this.setParts(this.looks);
    this.over.build();
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

  // Looks of the parts in each state (see `looksOf`), after one was hidden or the theme changed.
  setParts(looks) {
    this.looks = looks;
    looks.forEach((each, state) => this.setLooks(this.parts[state], each));
  }

  // Eight numbers a part: colour and opacity, displacement.
  setLooks(texture, looks) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 2, looks.length / 8, 0, gl.RGBA, gl.FLOAT, looks);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  // One frame of a picture (see `Viewer.picture`); of two states each in its stripe.
  paint(picture) {
    const { gl } = this;
    const { width, height } = picture;
    if (!this.scene.states) return this.paintState(picture, 0);
    gl.enable(gl.SCISSOR_TEST);
    for (const { state, from, to } of stripes(picture.wipe, width)) {
      gl.scissor(from, 0, to - from, height);
      this.paintState(picture, state);
    }
    gl.disable(gl.SCISSOR_TEST);
  }

  paintState(picture, state) {
    const { gl, scene } = this;
    const { width, height, matrices } = picture;
    const plane = picture.section ? inView(picture.section, matrices.view) : [0, 0, 0, -1];
    const use = (name) => {
      const { made, at } = this.programs[name];
      gl.useProgram(made);
      gl.uniformMatrix4fv(at.view, false, matrices.view);
      gl.uniformMatrix4fv(at.proj, false, matrices.proj);
      if (at.section) gl.uniform4fv(at.section, plane);
      if (at.parts) gl.bindTexture(gl.TEXTURE_2D, this.parts[state]);
      return at;
    };
    gl.viewport(0, 0, width, height);
    gl.clearColor(...picture.look.paper, 1);
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
      if (picture.bodies[k] && isOf(body, state)) this.paintBody(sphere, body, k);
    });
    this.over.paintGhosts(sphere, picture);
    if (this.faces) this.paintPlace(use, picture);
    gl.disable(gl.STENCIL_TEST);
    if (picture.through) this.paintThrough(use("SPHERE"), picture.through);
    this.over.paintVeils(use);
    const lines = this.lines.filter((line) => isOf(line, state));
    if (lines.length) {
      const at = use("MARK");
      gl.uniform2f(at.size, width, height);
      gl.uniform1f(at.width, picture.strokes);
      gl.disable(gl.DEPTH_TEST);
      gl.bindVertexArray(this.marks.vao);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.marks.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(lines.flatMap(lineNumbers)), gl.DYNAMIC_DRAW);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.length);
    }
  }

  paintBody(at, body, k) {
    const { gl } = this;
    gl.uniform1i(at.ghost, body.ghost ? 1 : 0);
    const mine = this.people[k];
    gl.bindVertexArray(mine.vao);
    if (mine.framed !== this.scene.frame) {
      for (const [buffer, array] of [[mine.at, body.centres], [mine.radius, body.radius], [mine.tint, body.tint]]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, array);
      }
      mine.framed = this.scene.frame;
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
    gl.bindVertexArray(this.edges.vao);
    gl.drawElements(gl.LINES, this.edges.count, gl.UNSIGNED_INT, 0);
    gl.useProgram(this.programs.MESH.made);
    gl.bindVertexArray(this.faces.vao);
    faces(1);
    gl.depthMask(true);
  }
}
