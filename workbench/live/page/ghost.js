// The saved state, see-through beside what is: people where they were, and what was moved.

import { coloured } from "/view/wire.js";
import { plain } from "/view/pick.js";
import { ask } from "./connection.js";
import { element } from "./elements.js";
import { cross } from "./gizmo.js";

const COLOUR = [150, 104, 226];
const LOOK = [...COLOUR.map((c) => c / 255), 0.34];
const INK = [0.36, 0.16, 0.66, 1];
const CROSS = 0.02; // m
const SAME = 1e-5; // m: what is nearer is where it was
const MOST = 3; // things that are named
const NOWHERE = [0, 0, 0];

const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
const mm = (metres) => `${(1000 * metres).toFixed(1)} mm`;

// How far [m] the farthest of some spheres is from where it was, and by how much one has grown.
export function farthest(now, then) {
  const [a, b] = [now.centres, then.centres];
  if (a.length !== b.length) return Infinity;
  let most = 0;
  for (let s = 0, k = 0; k < a.length; s++, k += 3) {
    const by = Math.hypot(a[k] - b[k], a[k + 1] - b[k + 1], a[k + 2] - b[k + 2]);
    most = Math.max(most, by, Math.abs(now.radius[s] - then.radius[s]));
  }
  return most;
}

// What was moved, in words: rows { name, by [m], lead }, the farthest first; those of one distance together.
export function movedWords(rows) {
  const alike = new Map();
  for (const { name, by, lead = "" } of rows.filter((row) => row.by > SAME)) {
    const key = Number.isFinite(by) ? `${lead}${mm(by)}` : "another body";
    alike.set(key, { by, names: [...(alike.get(key)?.names ?? []), plain(name)] });
  }
  const sorted = [...alike].sort((one, other) => other[1].by - one[1].by);
  const words = sorted.slice(0, MOST).map(([key, { names }]) => {
    const more = names.length > 1 ? ` and ${names.length - 1} more` : "";
    return `${names[0]}${more} ${key}`;
  });
  if (sorted.length > MOST) words.push(`${sorted.length - MOST} more`);
  return words.join(", ");
}

// Parts of a place moved by shifts [m] (by the index of a part), as a surface over the picture.
export function veilOfParts(place, shifts) {
  const number = new Map();
  const vertices = [];
  const corner = (k) => {
    if (!number.has(k)) {
      number.set(k, number.size);
      const by = shifts.get(place.part[k]);
      vertices.push(...by.map((value, i) => place.vertices[3 * k + i] + value));
    }
    return number.get(k);
  };
  const mine = (index) => Uint32Array.from(index.filter((k) => shifts.has(place.part[k])), corner);
  const triangles = mine(place.triangles);
  return veil(triangles, mine(place.edges), vertices);
}

function veil(triangles, edges, vertices) {
  const part = new Uint16Array(vertices.length / 3);
  return { vertices: Float32Array.from(vertices), part, triangles, edges, looks: [LOOK], ink: INK };
}

// The displacement [m] of a part from where a picture has it: that of a posture, or of a motion by the moves that it
// was packed with.
export function shiftOf({ shifts, moves }, name, packed) {
  if (!packed) return shifts[name] ?? NOWHERE;
  const by = (rows) => rows.find((move) => move.parts.includes(name))?.by ?? NOWHERE;
  const before = by(packed);
  return by(moves).map((value, k) => value - before[k]);
}

export class Ghost {
  // state: hello and answer; moves: gives the moves that a motion's picture was packed with, null where a posture is
  // shown; say: is told what has moved.
  constructor(state, moves, say) {
    Object.assign(this, { state, moves, say, panel: null, on: false, found: null, answer: null, key: "", drawn: "", told: false });
    this.legend = element("span", "", { className: "saved", hidden: true });
  }

  // Take the picture that is there now.
  attach(panel) {
    this.panel = panel;
    this.drawn = "";
    this.button = panel.button("ghost", () => this.toggle(), this.on);
    this.button.title = "G: what is saved, see-through beside what is";
    panel.bar.querySelector(".space").before(this.button);
    panel.over.append(this.legend);
    this.show();
  }

  toggle() {
    this.on = !this.on;
    this.button?.setAttribute("aria-pressed", this.on);
    this.key = "";
    this.told = !this.on;
    if (this.on) this.answered();
    else {
      this.found = null;
      this.say("");
    }
    this.show();
  }

  // The study was read or saved: another state is the saved one.
  forget() {
    this.key = "";
    this.found = null;
    if (this.on) this.answered();
  }

  // An answer has come; asks where the saved state of another case is needed, or of other adjustments.
  answered(answer = this.answer) {
    this.answer = answer;
    if (!this.on || !answer) return;
    const { case: name, adjustments } = answer.head;
    const key = JSON.stringify([name, adjustments.map((one) => one.at)]);
    if (key !== this.key) ask("ghost");
    this.key = key;
    this.show();
  }

  take(found) {
    const { controls, people } = this.state.hello;
    if (!this.on || found.head.controls.length !== controls.length) return;
    if (people.some((_, k) => !found.arrays[`centres${k}`])) return; // of the study as it was before it was read again
    this.found = found;
    this.show();
    if (!this.told) this.say(this.words);
    this.told = true;
  }

  get there() {
    return this.on && this.panel && this.found && this.answer && this.found.head.case === this.answer.head.case;
  }

  show() {
    this.legend.hidden = !this.there;
    if (!this.panel) return;
    const motion = this.there ? this.moves() : null;
    const people = this.there && !motion ? this.people() : [];
    const parts = this.there ? this.parts(motion) : [];
    const controls = this.there ? this.controls() : [];
    const moved = parts.filter((row) => row.by > SAME);
    const { adjusted = [] } = this.there ? this.found.head : {};
    this.words = this.sentence([...people, ...moved, ...controls], adjusted);
    this.legend.textContent = `▒ ${this.words}`;
    this.draw(people, moved, controls.filter((one) => one.by > SAME));
  }

  sentence(rows, adjusted) {
    const words = [movedWords(rows), adjusted.length ? `adjusted: ${adjusted.map(plain).join(", ")}` : ""].filter(Boolean);
    if (words.length) return `moved since saved: ${words.join("; ")}`;
    return `nothing moved ${this.answer?.head.unsaved ? "in this case " : ""}since saved`;
  }

  // Of each person the spheres as saved, and how far [m] one is at most from where it was.
  people() {
    const { arrays } = this.answer;
    return this.answer.head.people.map(({ role }, of) => {
      const read = (some) => ({ centres: some[`centres${of}`], radius: some[`radius${of}`] });
      const then = { ...read(this.found.arrays), segment: this.found.arrays[`segment${of}`] };
      return { name: role, lead: "up to ", of, then, by: farthest(read(arrays), then) };
    });
  }

  // The parts of the picture, each with its displacement as saved and how far [m] it is from there.
  parts(packed) {
    const { head } = this.found;
    const parts = this.panel.scene.place?.parts ?? [];
    const rows = parts.map(({ name }, k) => {
      const shift = shiftOf(head, name, packed);
      return { name, k, shift, by: far(shift, shiftOf(this.answer.head, name, packed)) };
    });
    return rows.filter(({ name }) => !head.adjusted.includes(name));
  }

  // The controls that go with no part that is shown, and how far [m] each is from where it was.
  controls() {
    const { hello, answer } = this.state;
    const alone = new Set([...answer.moves, ...this.found.head.moves].flatMap((move) => move.controls));
    return hello.controls.flatMap(({ name }, k) => {
      const at = this.found.head.controls[k];
      return alone.has(name) ? [{ name, at, by: far(at, answer.controls[k]) }] : [];
    });
  }

  // Paint it where it is another than before: it is not while something is dragged.
  draw(people, moved, controls) {
    const { viewer, scene } = this.panel;
    const unseen = people.map(({ of }) => scene.bodies[of]?.unseen);
    const key = JSON.stringify([this.there && this.key, moved.map((row) => row.name), controls.map((row) => row.name), unseen]);
    if (key === this.drawn && this.painted === this.found) return;
    this.drawn = key;
    this.painted = this.found;
    const ghosts = people.map(({ of, then }) => {
      const tint = coloured({ ...then, colour: COLOUR, unseen: unseen[of] }, []);
      return { of, centres: then.centres, radius: then.radius, tint };
    });
    const veils = [];
    const shifts = new Map(moved.map(({ k, shift }) => [k, shift]));
    if (shifts.size) veils.push(veilOfParts(scene.place, shifts));
    const { vertices, triangles, edges } = this.there ? this.found.arrays : {};
    if (vertices) veils.push(veil(triangles, edges, vertices));
    viewer.setOver(this.there ? { ghosts, veils } : null, "ghost");
    viewer.setMarks(controls.flatMap(({ at }) => cross(at, CROSS, COLOUR)), "ghost");
  }
}
