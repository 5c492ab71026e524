// Painting in a worker: what `Painting` of the viewer does, for a page that must go on meanwhile.

import { waited } from "./connection.js";

const HOLD = 100; // milliseconds for which an answer that is waited for has the processor for itself

// Whether this browser lets a worker paint.
export function canPaintFar() {
  if (typeof OffscreenCanvas === "undefined" || !HTMLCanvasElement.prototype.transferControlToOffscreen) return false;
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return Boolean(gl);
}

export class FarPainting {
  constructor(canvas, scene, { antialias, painted }) {
    Object.assign(this, { scene, painting: false, frame: scene.frame, shots: [] });
    this.worker = new Worker("/page/painter.js", { type: "module" });
    this.worker.onmessage = ({ data }) => {
      if (data.shot) return this.shots.shift().resolve(data.shot);
      if (data.refused) return this.shots.shift().reject(new Error(data.refused));
      this.painting = false;
      return painted();
    };
    const far = canvas.transferControlToOffscreen();
    this.worker.postMessage({ act: "begin", canvas: far, antialias, scene: paintedOf(scene) }, [far]);
  }

  get busy() {
    const wait = waited();
    return this.painting || (wait > 0 && wait < HOLD);
  }

  tell(act, given) {
    this.worker.postMessage({ act, ...given });
  }

  setParts(looks) {
    this.tell("setParts", { looks });
  }

  setMarks(lines) {
    this.tell("setMarks", { lines });
  }

  setOver(given) {
    this.tell("setOver", { given });
  }

  paint(picture) {
    this.painting = true;
    this.tell("paint", { picture, bodies: this.news() });
  }

  // What of the bodies the worker does not know yet; null where it knows all.
  news() {
    const { scene } = this;
    const bodies = this.frame === scene.frame ? null : scene.bodies.map(moved);
    this.frame = scene.frame;
    return bodies;
  }

  shot(picture, lines) {
    this.tell("shot", { picture, lines, bodies: this.news() });
    return new Promise((resolve, reject) => this.shots.push({ resolve, reject }));
  }

  end() {
    this.worker.terminate();
    for (const one of this.shots) one.reject(new Error("the picture is another by now"));
  }
}

// What changes of a body from frame to frame: a copy, since a view of an array takes all of it along.
const moved = ({ centres, tint }) => ({ centres: centres.slice(), tint });

// What of a scene is painted.
function paintedOf({ place, bodies, states }) {
  const still = place && (({ vertices, part, triangles, edges }) => ({ vertices, part, triangles, edges }))(place);
  const each = ({ radius, ghost, state, ...body }) => ({ radius, ghost, state, ...moved(body) });
  return { place: still, states, bodies: bodies.map(each) };
}
