// A turnable picture of bodies made of spheres in a place made of polygons: raw WebGL2.
// It knows arrays, not pages: report, notebook and bench hand it a scene (see wire.js).

import { Camera } from "./camera.js";
import { Painting } from "./painting.js";
import { looksOf } from "./programs.js";
import { boundsOf } from "./wire.js";
import { isOf, stateAt } from "./wipe.js";

const REST = 350; // milliseconds without a change after which the picture is drawn in full
const ROUGH = 0.4; // size while something moves, where a program draws and no graphics card
const SLOW = 40; // milliseconds of a first frame from which it counts as such
const LOOKS = {
  light: { paper: [0.957, 0.964, 0.972], ink: [0.2, 0.24, 0.3, 0.8], part: 1 },
  dark: { paper: [0.075, 0.09, 0.115], ink: [0.02, 0.03, 0.04, 0.9], part: 0.62 },
};

let slow = null; // whether GL is software, found once a page

// Whether a program draws, and no graphics card.
export function isSoftware() {
  if (slow !== null) return slow;
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return (slow = false);
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  slow = /swiftshader|llvmpipe|software|basic render/i.test(name);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return slow;
}

export class Viewer extends EventTarget {
  // Paints: what paints the canvas, here or in another thread.
  constructor(canvas, scene, Paints = Painting) {
    super();
    this.canvas = canvas;
    this.scene = scene;
    this.camera = new Camera();
    this.look = LOOKS.light;
    this.section = null;
    this.wipe = 0.5; // of two states: where across the picture the second begins
    this.walls = false; // whether walls before a body are opaque
    this.scale = 1;
    this.stroke = 1.1;
    this.through = null; // { body, ranges }: spheres that are seen through what hides them
    this.hiddenBodies = new Set();
    this.hiddenParts = new Set();
    this.lines = new Map();
    this.overs = new Map();
    this.painting = new Paints(canvas, scene, { antialias: !isSoftware(), painted: () => this.dispatchEvent(new Event("frame")) });
    this.partsChanged();
    this.watch = new ResizeObserver(() => this.draw());
    this.watch.observe(canvas);
  }

  shown = { body: (k) => !this.hiddenBodies.has(k), part: (k) => !this.hiddenParts.has(k) };

  // What is shown at a place across the picture: of two states that which is seen there.
  shownAt(across) {
    const { scene, shown } = this;
    if (!scene.states) return shown;
    const state = stateAt(this.wipe, across);
    return {
      body: (k) => shown.body(k) && isOf(scene.bodies[k], state),
      part: (k) => shown.part(k) && isOf(scene.place.parts[k], state),
    };
  }

  theme(dark) {
    this.look = dark ? LOOKS.dark : LOOKS.light;
    this.partsChanged();
  }

  // A part was hidden, shown or moved, or the theme changed.
  partsChanged() {
    const { place, states } = this.scene;
    const { parts } = place ?? {};
    const looks = (state) => looksOf(parts, (k) => this.shown.part(k) && isOf(parts[k], state), this.look.part);
    if (parts) this.painting.setParts((states ?? [0]).map((_, state) => looks(state)));
    this.draw();
  }

  // Lines from point to point: [{ from, to, colour }]; those of another owner stay.
  setMarks(lines, owner = "") {
    this.lines.set(owner, lines);
    this.painting.setMarks([...this.lines.values()].flat());
    this.draw();
  }

  // What lies over the scene, { ghosts, veils }: see over.js; that of another owner stays. null for nothing.
  setOver(over, owner) {
    this.overs.set(owner, over ?? {});
    const every = (name) => [...this.overs.values()].flatMap((one) => one[name] ?? []);
    this.painting.setOver({ ghosts: every("ghosts"), veils: every("veils") });
    this.draw();
  }

  // Let some spheres of a body be seen through what hides them: { body, ranges: [[from, to]] }, or null.
  setThrough(through) {
    if (JSON.stringify(through) === JSON.stringify(this.through)) return;
    this.through = through;
    this.draw();
  }

  fit() {
    this.resize();
    this.camera.fit(boundsOf(this.scene));
    this.draw();
  }

  // Draw soon; roughly while something moves and GL is slow, in full when it has come to rest.
  draw() {
    clearTimeout(this.resting);
    if (slow && this.moving) {
      this.scale = ROUGH;
      this.resting = setTimeout(() => {
        this.moving = false;
        this.scale = 1;
        this.draw();
      }, REST);
    }
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = 0;
      this.render();
    });
  }

  moved() {
    this.moving = true;
    this.draw();
  }

  resize() {
    const { canvas } = this;
    this.camera.aspect = (canvas.clientWidth || 1) / (canvas.clientHeight || 1);
  }

  // All that a frame shows, apart from the scene, as plain data; strokes: half the width of a line in pixels.
  picture(scale = this.scale) {
    const { canvas, camera, look, section, walls, through, wipe, shown } = this;
    const ratio = (window.devicePixelRatio || 1) * scale;
    return {
      ...{ look, section, walls, through, wipe, strokes: this.stroke * ratio },
      width: Math.max(1, Math.round(canvas.clientWidth * ratio)),
      height: Math.max(1, Math.round(canvas.clientHeight * ratio)),
      matrices: camera.matrices(),
      bodies: this.scene.bodies.map((_, k) => shown.body(k)),
    };
  }

  // A promise of the picture in full, as pixels { width, height, data }, without the lines of some owners.
  async shot(without = []) {
    this.resize();
    const lines = [...this.lines].flatMap(([owner, some]) => (without.includes(owner) ? [] : some));
    return this.painting.shot(this.picture(1), lines);
  }

  render() {
    if (this.gone) return;
    if (this.painting.busy) return this.draw(); // the newest is painted once that is done
    this.resize();
    const start = performance.now();
    this.painting.paint(this.picture());
    if (slow === false && !this.timed) {
      this.painting.finish();
      slow = performance.now() - start > SLOW && this.frames > 0;
      this.timed = this.frames > 0;
    }
    this.frames = (this.frames || 0) + 1;
  }

  // Give the context back: a browser keeps few of them.
  end() {
    this.gone = true;
    this.watch.disconnect();
    cancelAnimationFrame(this.asked);
    clearTimeout(this.resting);
    this.painting.end();
  }
}
