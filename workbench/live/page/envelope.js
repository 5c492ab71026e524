// How far the chosen hand reaches all around, see-through in the picture, with its sections.

import { ask } from "./connection.js";
import { at, element } from "./elements.js";

const FREE = [0.25, 0.5, 0.72, 0.22];
const SHORT = [0.82, 0.27, 0.23, 0.3];
const STALE = [0.5, 0.5, 0.5, 0.16];
const INK = [0.1, 0.25, 0.5, 0.9];

// The surface as the picture takes it: each triangle by itself, so that it has a colour of its own.
export function veilOf({ points, faces, short, lines }, stale) {
  const vertices = new Float32Array(3 * faces.length + lines.length);
  faces.forEach((corner, k) => vertices.set(points.subarray(3 * corner, 3 * corner + 3), 3 * k));
  vertices.set(lines, 3 * faces.length);
  const part = new Uint16Array(vertices.length / 3);
  for (let k = 0; k < faces.length; k++) part[k] = short[Math.floor(k / 3)];
  const triangles = Uint32Array.from(faces, (_, k) => k);
  const edges = Uint32Array.from({ length: lines.length / 3 }, (_, k) => faces.length + k);
  return { vertices, part, triangles, edges, looks: stale ? [STALE, STALE] : [FREE, SHORT], ink: INK };
}

export class Envelope {
  // chosen: gives { person, limb, obstacles } of the hand that is chosen; say: is told what goes on.
  constructor(chosen, say) {
    Object.assign(this, { chosen, say, panel: null, found: null, stale: false });
    at("envelope-ask").onclick = () => this.ask();
    at("envelope-away").onclick = () => this.away();
  }

  attach(panel) {
    this.panel = panel;
    this.draw();
  }

  ask() {
    const { person, limb, obstacles } = this.chosen();
    if (!limb?.endsWith("hand")) return this.say("choose a hand: the reach envelope is that of a hand", true);
    ask("envelope", { person, limb, obstacles });
  }

  take({ head, arrays }, generation) {
    this.found = { head, arrays };
    this.stale = head.generation !== generation;
    this.say("");
    this.show();
  }

  // The state is another: the envelope is that of an earlier one.
  answered(head) {
    if (!this.found || this.stale || head.generation === this.found.head.generation) return;
    this.stale = true;
    this.show();
  }

  show() {
    const { head } = this.found;
    const lost = head.lost === null ? "" : `, of which obstacles take ${head.lost}`;
    const old = this.stale ? " It is that of an earlier state." : "";
    at("envelope-words").textContent = `${head.person}: the ${head.limb} reaches a space of ${head.litres} litres${lost}.${old}`;
    const pictures = head.sections.map(([name, svg]) => {
      const figure = element("figure");
      const src = `data:image/svg+xml,${encodeURIComponent(svg)}`;
      figure.append(element("img", "", { src, alt: `section: ${name}`, loading: "lazy" }), element("figcaption", name));
      return figure;
    });
    at("envelope-sections").replaceChildren(...pictures);
    at("envelope").hidden = false;
    at("envelope").classList.toggle("waiting", this.stale);
    this.draw();
  }

  away() {
    this.found = null;
    at("envelope").hidden = true;
    this.draw();
  }

  draw() {
    this.panel?.viewer.setOver(this.found && { veils: [veilOf(this.found.arrays, this.stale)] }, "envelope");
  }
}
