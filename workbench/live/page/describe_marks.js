// Lines and names over the picture: what was picked, seats, controls, points, and where forward is.

import { vec } from "/view/camera.js";
import { plain } from "/view/pick.js";

const CUSHION = [24, 128, 132];
const BACK = [206, 84, 20];
const SEAT = [44, 96, 214];
const CONTROL = [178, 40, 130];
const POINT = [150, 110, 0];
const WAY = [110, 120, 132];
const ARM = 0.025; // metres of a cross
const SHIFTS = [0, -8, 8, -16, 16]; // pixels by which a name makes room for others
const LENGTHS = { cushion: 0.45, back: 0.6, across: 0.2 }; // metres

export class Marks {
  constructor() {
    Object.assign(this, { panel: null, head: null, lines: [], names: [] });
  }

  attach(panel) {
    this.panel = panel;
    panel.viewer.stroke = 1.8;
    panel.viewer.addEventListener("frame", () => this.place());
    this.draw();
  }

  show(head, arrays) {
    this.head = head;
    this.lines = [];
    this.texts = [];
    head.seats.forEach((seat, k) => {
      this.lines.push(...pairs(arrays[`cushion${k}`], CUSHION), ...pairs(arrays[`back${k}`], BACK));
      if (seat.there) this.seat(seat);
    });
    for (const one of head.controls) this.cross(one, CONTROL);
    for (const one of head.points) this.cross(one, POINT);
    if (head.parts.length) this.forward(head);
    this.draw();
  }

  seat({ name, srp, cushion_angle: cushion, back_angle: back, yaw }) {
    const turn = (degrees) => (degrees * Math.PI) / 180;
    const ahead = [Math.cos(turn(yaw)), Math.sin(turn(yaw)), 0];
    const aside = [-ahead[1], ahead[0], 0];
    const along = (angle) => vec.add(vec.mul(ahead, Math.cos(angle)), [0, 0, Math.sin(angle)]);
    const up = vec.add(vec.mul(ahead, -Math.sin(turn(back))), [0, 0, Math.cos(turn(back))]);
    const line = (way, length) => ({ from: srp, to: vec.add(srp, vec.mul(way, length)), colour: SEAT });
    this.lines.push(line(along(turn(cushion)), LENGTHS.cushion), line(up, LENGTHS.back));
    this.lines.push(line(aside, LENGTHS.across), line(aside, -LENGTHS.across));
    this.texts.push({ at: srp, words: `${name}: SRP` });
  }

  cross({ name, at }, colour) {
    for (let k = 0; k < 3; k++) {
      const arm = [0, 0, 0];
      arm[k] = ARM;
      this.lines.push({ from: vec.sub(at, arm), to: vec.add(at, arm), colour });
    }
    this.texts.push({ at, words: plain(name) });
  }

  // An arrow ahead of the mesh, on its foot.
  forward({ parts, size }) {
    const low = Math.min(...parts.map((part) => part.at[2] - part.size[2] / 2));
    const front = Math.max(...parts.map((part) => part.at[0] + part.size[0] / 2));
    const left = Math.max(...parts.map((part) => part.at[1] + part.size[1] / 2));
    const from = [front, left - size[1] / 2, low];
    const long = 0.25 * Math.max(...size);
    const tip = vec.add(from, [long, 0, 0]);
    for (const side of [-1, 1]) {
      this.lines.push({ from: tip, to: vec.add(tip, [-0.2 * long, side * 0.1 * long, 0]), colour: WAY });
    }
    this.lines.push({ from, to: tip, colour: WAY });
    this.texts.push({ at: tip, words: "forward", way: true });
  }

  draw() {
    if (!this.panel || !this.head) return;
    for (const one of this.names) one.remove();
    this.names = this.texts.map(({ words, way }) => {
      const made = document.createElement("span");
      made.className = way ? "place way" : "place";
      made.textContent = words;
      this.panel.over.append(made);
      return made;
    });
    this.panel.viewer.setMarks(this.lines);
    this.place();
  }

  place() {
    const { canvas, camera } = this.panel.viewer;
    const taken = [];
    this.texts.forEach(({ at }, k) => {
      const seen = camera.project(at);
      const name = this.names[k];
      name.hidden = !seen;
      if (!seen) return;
      const x = (0.5 + 0.5 * seen[0]) * canvas.clientWidth;
      const high = (0.5 - 0.5 * seen[1]) * canvas.clientHeight;
      const wide = 7 * name.textContent.length + 14;
      const free = (y) => !taken.some((one) => Math.abs(one.y - y) < 18 && x < one.x + one.wide && one.x < x + wide);
      const y = SHIFTS.map((by) => high + by).find(free);
      name.hidden = y === undefined; // its cross is there; who looks closer sees the name too
      if (name.hidden) return;
      taken.push({ x, y, wide });
      Object.assign(name.style, { left: `${x}px`, top: `${y}px` });
    });
  }
}

// The lines of a flat array of ends.
function pairs(ends, colour) {
  const lines = [];
  for (let k = 0; k + 5 < (ends?.length ?? 0); k += 6) {
    lines.push({ from: [...ends.subarray(k, k + 3)], to: [...ends.subarray(k + 3, k + 6)], colour });
  }
  return lines;
}

// The box of all that is in a picture, people too.
export function everything(scene) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const points of [scene.place.vertices, ...scene.bodies.map((body) => body.centres)]) {
    for (let i = 0; i < points.length; i++) {
      if (points[i] < low[i % 3]) low[i % 3] = points[i];
      if (points[i] > high[i % 3]) high[i % 3] = points[i];
    }
  }
  return [low, high];
}
