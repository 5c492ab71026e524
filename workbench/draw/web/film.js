// The bar below the picture of a motion: play, scrubber and time; and under them the least gap of
// every frame, with the limit of what is asked for.

import { element } from "./list.js";

const SHORTEST = 4000; // milliseconds that a motion takes at least when it is played
const SPAN = 1000; // of the drawing of gaps, in its own units
const TALL = 100;
const MOST_GAP = 0.1; // m: gaps beyond are not told apart
const SPARE = 0.06; // of the height that stays free above and below

export class Film {
  // times [ms] of the frames; words: a time in words; show: is given the frame that is wanted;
  // ready: whether a frame is there, while the film plays.
  constructor({ times, words, show, ready = () => true }) {
    Object.assign(this, { times, words, show, ready, frame: 0, playing: 0, worst: null });
    this.time = element("input", { type: "range", min: 0, max: times.length - 1, value: 0 });
    this.time.setAttribute("aria-label", "time");
    this.clock = element("output", { ariaLive: "off" }); // the slider says its time itself
    this.play = element("button", { type: "button", textContent: "play", onclick: () => this.toggle() });
    this.bar = element("div", { className: "film" }, this.play, this.time, this.clock);
    this.time.oninput = () => {
      this.stop();
      this.show(Number(this.time.value));
    };
  }

  // A frame is shown.
  at(frame) {
    this.frame = frame;
    this.time.value = frame;
    this.clock.textContent = this.words(this.times[frame]);
    this.time.setAttribute("aria-valuetext", this.clock.textContent);
    this.cursor?.setAttribute("transform", `translate(${this.across(this.times[frame])} 0)`);
  }

  stop() {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    this.play.textContent = "play";
  }

  // Once through, from where it stands or from the beginning: in its own time, but slower where that
  // is less than four seconds.
  toggle() {
    if (this.playing) return this.stop();
    const { times } = this;
    const last = times.length - 1;
    const pace = Math.min(1, (times[last] - times[0]) / SHORTEST);
    let time = times[this.frame < last ? this.frame : 0];
    let before = 0;
    const step = (now) => {
      if (before) time += (now - before) * pace;
      before = now;
      const frame = frameAt(times, time);
      if (!this.ready(frame)) time = times[this.frame]; // waits for it
      else if (frame !== this.frame) this.show(frame);
      if (this.frame === last) return this.stop();
      this.playing = requestAnimationFrame(step);
    };
    this.play.textContent = "pause";
    this.playing = requestAnimationFrame(step);
  }

  across(time) {
    const { times } = this;
    return (SPAN * (time - times[0])) / (times[times.length - 1] - times[0] || 1);
  }

  // Draw how near the frames come: times [ms] of them, the least gap of each [m] (NaN: not known),
  // words about the least one; and what a criterion finds, with its limit [m] and its name.
  gaps({ times, least, words, asked, limit, name }) {
    this.curves ??= this.drawing();
    const low = Math.min(0, limit ?? 0, lowest(least), lowest(asked ?? []));
    const high = Math.max(MOST_GAP, limit === undefined ? 0 : limit + MOST_GAP / 2);
    const y = (gap) => TALL * (1 - SPARE - ((1 - 2 * SPARE) * (Math.min(gap, high) - low)) / (high - low));
    const line = (gaps) => path(times, gaps, (time) => this.across(time), y);
    this.curves.least.setAttribute("d", line(least));
    this.curves.asked.setAttribute("d", asked ? line(asked) : "");
    this.curves.limit.setAttribute("d", limit === undefined ? "" : `M0 ${y(limit)}H${SPAN}`);
    this.curves.zero.setAttribute("d", `M0 ${y(0)}H${SPAN}`);
    const k = worstOf(least);
    this.worst = k < 0 ? null : times[k];
    this.curves.worst.setAttribute("d", k < 0 ? "" : `M${this.across(times[k])} ${y(least[k])}h0`);
    const mm = (gap) => `${(1000 * gap).toFixed(1)} mm`.replace("-", "−");
    this.least.hidden = k < 0;
    if (k >= 0) this.least.textContent = `least gap ${mm(least[k])} at ${this.words(times[k])}${words ? `: ${words}` : ""}`;
    const bound = (gap) => {
      if (gap === 0) return "no overlap is allowed";
      return gap > 0 ? `${mm(gap)} are asked for` : `${mm(-gap)} of overlap are allowed`;
    };
    this.asks.textContent = limit === undefined ? "" : `${name}: ${bound(limit)}`;
    this.asks.hidden = limit === undefined;
  }

  // The elements of the drawing, which also goes to the frame that is clicked.
  drawing() {
    const made = (kind, className) => {
      const one = document.createElementNS("http://www.w3.org/2000/svg", kind);
      one.setAttribute("class", className);
      return one;
    };
    const picture = made("svg", "gaps");
    picture.setAttribute("viewBox", `0 0 ${SPAN} ${TALL}`);
    picture.setAttribute("preserveAspectRatio", "none");
    picture.setAttribute("aria-hidden", "true");
    const rows = Object.fromEntries(["zero", "limit", "asked", "least", "worst"].map((name) => [name, made("path", name)]));
    this.cursor = made("path", "cursor");
    this.cursor.setAttribute("d", `M0 0V${TALL}`);
    picture.append(...Object.values(rows), this.cursor);
    picture.addEventListener("click", (event) => {
      const box = picture.getBoundingClientRect();
      const { times } = this;
      this.go(times[0] + ((times[times.length - 1] - times[0]) * (event.clientX - box.left)) / box.width);
    });
    this.least = element("button", { type: "button", className: "least", onclick: () => this.go(this.worst) });
    this.asks = element("span", { className: "asks" });
    this.bar.append(picture, element("div", { className: "words" }, this.least, this.asks));
    this.at(this.frame);
    return rows;
  }

  // Go to the frame nearest to a time [ms].
  go(time) {
    this.stop();
    const frame = frameAt(this.times, time);
    const { times } = this;
    this.show(frame + 1 < times.length && times[frame + 1] - time < time - times[frame] ? frame + 1 : frame);
  }
}

// The last frame that is not after a time, the first one at least.
export function frameAt(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

const lowest = (gaps) => gaps.reduce((least, gap) => (gap < least ? gap : least), Infinity);

// Where the least of some gaps is, -1 where none is known.
export function worstOf(gaps) {
  return gaps.reduce((best, gap, k) => (gap < (best < 0 ? Infinity : gaps[best]) ? k : best), -1);
}

// A line through gaps over their times, broken where none is known; of those that fall on one place
// the least.
export function path(times, gaps, across, y) {
  const rows = [];
  let broken = true;
  for (let k = 0; k < gaps.length; k++) {
    if (Number.isNaN(gaps[k])) {
      broken = true;
      continue;
    }
    const x = Math.round(across(times[k]) * 2) / 2;
    const last = rows[rows.length - 1];
    if (last && !broken && last.x === x) last.gap = Math.min(last.gap, gaps[k]);
    else rows.push({ x, gap: gaps[k], begin: broken });
    broken = false;
  }
  return rows.map(({ x, gap, begin }) => `${begin ? "M" : "L"}${x} ${y(gap).toFixed(1)}`).join("");
}
