// What paints a canvas: its context, lost and restored, and what lives on the graphics card.

import { Card } from "./card.js";

const DEFAULTS = { alpha: false, stencil: true, powerPreference: "high-performance" };

export class Painting {
  // canvas: of a page, or of a worker; painted: is called after each frame.
  constructor(canvas, scene, { antialias, painted }) {
    Object.assign(this, { canvas, painted, busy: false, last: null });
    this.gl = canvas.getContext("webgl2", { ...DEFAULTS, antialias });
    if (!this.gl) throw new Error("this browser has no WebGL 2 here");
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.lost = true;
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      this.card.build();
      if (this.last) this.paint(this.last);
    });
    this.card = new Card(this.gl, scene);
  }

  setParts(looks) {
    if (this.lost) this.card.looks = looks;
    else this.card.setParts(looks);
  }

  setMarks(lines) {
    this.card.lines = lines;
  }

  setOver(given) {
    if (this.lost) this.card.over.given = given;
    else this.card.over.set(given);
  }

  paint(picture) {
    this.last = picture;
    if (this.lost) return;
    this.put(picture);
    this.painted();
  }

  put(picture) {
    const { canvas } = this;
    const { width, height } = picture;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.card.paint(picture);
  }

  // The pixels of a picture with some lines, rows from top to bottom; what was shown before is shown again.
  shot(picture, lines) {
    if (this.lost) throw new Error("the graphics card is lost for the moment");
    const { gl, card, last } = this;
    const before = card.lines;
    const { width, height } = picture;
    card.lines = lines;
    this.put(picture);
    const data = new Uint8ClampedArray(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    card.lines = before;
    if (last) this.put(last);
    return { width, height, data: upright(data, 4 * width) };
  }

  // Wait until the last frame is there.
  finish() {
    const { gl } = this;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // Give the context back: a browser keeps few of them.
  end() {
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

// GL has the lowest row first.
function upright(data, row) {
  const turned = new Uint8ClampedArray(data.length);
  for (let k = 0; k < data.length; k += row) turned.set(data.subarray(k, k + row), data.length - k - row);
  return turned;
}
