// A motion that is played: its frames come in windows as they are wanted, the gaps piece by piece.

import { readBlock, sceneOf } from "/view/wire.js";
import { ask } from "./connection.js";

const KEPT = 32e6; // bytes of windows: two people of 400 spheres in 3,000 frames
const REST = 300; // milliseconds after a change before its gaps are asked for

// What is left of several gap curves: that of the criterion that is nearest to failing.
export function nearestToFailing(rows, asked) {
  let best = null;
  rows.forEach((row, q) => {
    const least = asked[q].reduce((low, gap) => (gap < low ? gap : low), Infinity) - row.limit;
    if (least < (best?.least ?? Infinity)) best = { ...row, least, gaps: asked[q] };
  });
  return best;
}

// The frame of a window's grid that a frame belongs to.
export const startOf = (frame, window) => window * Math.floor(frame / window);

// The starts of windows to let go, the one that was looked at longest ago first, until no more than `most` bytes
// are held. The one that is shown and the last that came stay, however large.
export function surplus(windows, shown, most = KEPT) {
  let held = 0;
  for (const { bytes } of windows.values()) held += bytes;
  const gone = [];
  for (const start of [...windows.keys()].slice(0, -1)) {
    if (held <= most) break;
    if (start === shown) continue;
    held -= windows.get(start).bytes;
    gone.push(start);
  }
  return gone;
}

export class Motion {
  // picture: where it is shown; say: is told what goes on; shown: is called when a frame is shown.
  constructor(picture, say, shown) {
    Object.assign(this, { picture, say, shown, name: "", head: null, generation: 0, moves: [], wanted: null });
    this.windows = new Map();
    this.asked = new Set();
  }

  get there() {
    return Boolean(this.name);
  }

  // Play or pause; what is not there yet is played once it is.
  play(opened = true) {
    if (!opened) return (this.wantsPlay = true); // what is opened is perhaps a motion
    if (!this.there) return this.say("this case is a posture: only motions are played", true);
    if (this.panel) return this.panel.toggle();
    this.wantsPlay = !this.wantsPlay;
    this.say(this.wantsPlay ? "the motion will be played once it is there" : "the motion is being read");
  }

  // Show a motion, at a time [s] or where it begins.
  open(name, time = null) {
    this.wanted = time;
    if (this.name === name && this.panel) return this.toWanted();
    this.name = name;
    this.head = this.panel = null;
    document.body.dataset.motion = name;
    ask("motion", { case: name });
  }

  // The study was read anew: show the same motion of it, or the first.
  reopen(names) {
    const name = names.includes(this.name) ? this.name : names[0];
    this.close();
    this.open(name);
  }

  close() {
    this.name = "";
    this.head = this.panel = null;
    delete document.body.dataset.motion;
  }

  async take({ head, arrays }) {
    if (head.case !== this.name) return;
    if (head.kind === "motion") await this.takeScene(head, arrays);
    else if (head.generation !== this.generation || !this.panel) return;
    else if (head.kind === "frames") await this.takeFrames(head, arrays);
    else this.takeGaps(head, arrays);
  }

  async takeScene(head, arrays) {
    const scene = sceneOf(await readBlock(arrays.block), 0);
    if (head.case !== this.name) return;
    this.head = head;
    this.times = arrays.times;
    Object.assign(scene, { times: arrays.times, clock: (ms) => `${(ms / 1000).toFixed(3)} s`, first: 0 });
    scene.ready = (frame) => this.ready(frame);
    this.packed = head.moves;
    this.panel = null;
    this.scene = scene;
    this.panel = this.picture.replace(scene);
    this.say("");
    if (this.wantsPlay) this.panel.toggle();
    this.wantsPlay = false;
    this.anew(this.latest ?? head.generation);
    this.place();
    this.toWanted();
  }

  toWanted() {
    if (this.wanted !== null) this.panel.film.go(1000 * this.wanted);
    this.wanted = null;
  }

  // The state is another: what was known of its frames no longer holds.
  anew(generation) {
    this.generation = generation;
    this.windows.clear();
    this.asked.clear();
    this.gaps = null;
    this.ready(this.panel.film.frame);
    ask("gaps", { case: this.name });
  }

  // An answer has come: parts may stand elsewhere.
  answered(head) {
    this.moves = head.moves;
    this.latest = head.generation;
    if (!this.panel) return;
    this.place();
    if (head.generation === this.generation) return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.panel && this.anew(this.latest), REST);
  }

  // Parts where the state has them, from where the picture was packed with them.
  place() {
    const by = (moves, name) => moves.find((move) => move.parts.includes(name))?.by ?? [0, 0, 0];
    for (const part of this.scene.place?.parts ?? []) {
      const before = by(this.packed, part.name);
      part.shift = by(this.moves, part.name).map((value, k) => value - before[k]);
    }
    this.panel.viewer.partsChanged();
  }

  // Whether a frame is there, which is put into the scene; else it is asked for.
  ready(frame) {
    if (!this.panel) return false;
    const { window, frames } = this.head;
    const start = startOf(frame, window);
    this.want(start);
    if (frame - start > window / 2 && start + window < frames) this.want(start + window);
    const found = this.windows.get(start);
    if (!found) return false;
    this.windows.delete(start); // the last in the order of the map: it was looked at last
    this.windows.set(start, found);
    if (this.scene.first !== start || this.scene.window !== found) {
      this.scene.first = start;
      this.scene.window = found;
      this.scene.bodies.forEach((body, k) => Object.assign(body, { frames: found.bodies[k].frames, touching: found.bodies[k].touching }));
    }
    this.frame = frame;
    ask("near", { case: this.name, frame });
    queueMicrotask(() => this.shown()); // once the frame is in the picture
    return true;
  }

  want(start) {
    if (this.asked.has(start)) return;
    this.asked.add(start);
    const to = Math.min(start + this.head.window, this.head.frames);
    ask("frames", { case: this.name, from: start, to });
  }

  async takeFrames(head, arrays) {
    const { generation } = this;
    const { bodies } = sceneOf(await readBlock(arrays.block), 0);
    if (generation !== this.generation || !this.panel) return;
    const eyes = this.head.people.map((_, k) => arrays[`eyes${k}`]?.slice()); // without the message that they came in
    const bytes = [...bodies.map((body) => body.frames), ...eyes].reduce((sum, some) => sum + (some?.byteLength ?? 0), 0);
    this.windows.set(head.from, { bodies, eyes, bytes });
    const now = this.panel.film.frame;
    const shown = startOf(now, this.head.window);
    for (const start of surplus(this.windows, shown)) {
      this.windows.delete(start);
      this.asked.delete(start);
    }
    if (shown === head.from) this.panel.at(now);
  }

  // Where somebody looks from in the frame that is shown: { at, sight, up, head, body }, or null.
  eyes(person) {
    const k = Math.max(0, this.head?.people.findIndex((one) => one.role === person) ?? 0);
    const start = this.scene?.first;
    const rows = this.windows.get(start)?.eyes[k];
    if (!rows || this.head.people[k].head === null) return null;
    const row = [...rows.subarray(9 * (this.frame - start), 9 * (this.frame - start + 1))];
    const body = this.head.people.slice(0, k).reduce((sum, one) => sum + one.bodies, 0);
    const { role, head } = this.head.people[k];
    return { role, head, body, at: row.slice(0, 3), sight: row.slice(3, 6), up: row.slice(6) };
  }

  takeGaps(head, arrays) {
    const unknown = () => new Float32Array(head.of).fill(NaN);
    this.gaps ??= { least: unknown(), asked: head.rows.map(unknown), words: "", worst: Infinity };
    const { gaps } = this;
    gaps.least.set(arrays.least, head.from);
    head.rows.forEach((_, q) => gaps.asked[q].set(arrays[`asked${q}`], head.from));
    const least = arrays.least.reduce((low, gap) => Math.min(low, gap), Infinity);
    if (least < gaps.worst) Object.assign(gaps, { worst: least, words: head.worst.words });
    const near = nearestToFailing(head.rows, gaps.asked);
    const asked = near ? { asked: near.gaps, limit: near.limit, name: near.name } : {};
    this.panel.film.gaps({ times: this.times, least: gaps.least, words: gaps.words, ...asked });
  }
}
