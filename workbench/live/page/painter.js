// A worker that paints a canvas of the page: where a program draws and no graphics card, a frame keeps
// the thread that paints it for tens of milliseconds, in which the page would answer nothing.

import { Painting } from "/view/painting.js";

let painting = null;
let scene = null;

const acts = {
  begin({ canvas, ...given }) {
    scene = given.scene;
    painting = new Painting(canvas, scene, { antialias: given.antialias, painted: () => postMessage("painted") });
  },
  setParts: ({ looks }) => painting.setParts(looks),
  setMarks: ({ lines }) => painting.setMarks(lines),
  setOver: ({ given }) => painting.setOver(given),
  paint({ picture, bodies }) {
    take(bodies);
    requestAnimationFrame(() => painting.paint(picture));
  },
  shot({ picture, lines, bodies }) {
    take(bodies);
    try {
      const shot = painting.shot(picture, lines);
      postMessage({ shot }, [shot.data.buffer]);
    } catch (error) {
      postMessage({ refused: error.message });
    }
  },
};

// The bodies are elsewhere; null where they are not.
function take(bodies) {
  bodies?.forEach((body, k) => Object.assign(scene.bodies[k], body));
  if (bodies) scene.frame = (scene.frame || 0) + 1;
}

onmessage = ({ data }) => acts[data.act](data);
