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
    Object.assign(this, { scene, painting: false, frame: scene.frame });
    this.worker = new Worker("/page/painter.js", { type: "module" });
    this.worker.onmessage = () => {
      this.painting = false;
      painted();
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
    const { scene } = this;
    const bodies = this.frame === scene.frame ? null : scene.bodies.map(moved);
    this.frame = scene.frame;
    this.painting = true;
    this.tell("paint", { picture, bodies });
  }

  end() {
    this.worker.terminate();
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
