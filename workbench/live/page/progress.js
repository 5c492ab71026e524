// What is being done while a study is opened, and for how long: the steps one after the other.

import { at, element } from "./elements.js";

const TICK = 500; // milliseconds
const LONG = 6; // seconds after which it is said why something may take long
const FIRST = "On a machine that has never done this, the program is made ready first, once; that takes minutes.";

// The words of a step: its number, what is done and for how long.
export function stepWords(number, of, words, seconds) {
  const long = seconds < 1 ? "" : `, ${Math.floor(seconds)} s`;
  return `Step ${number} of ${of}: ${words}${long}.`;
}

export class Progress {
  constructor() {
    Object.assign(this, { steps: [], at: 0, begun: performance.now(), ticking: 0 });
    this.bar = element("progress");
    this.words = element("span");
    this.why = element("small");
    document.querySelector("#picture .still").replaceChildren(this.bar, this.words, this.why);
    this.begin(["the study is being opened"]);
  }

  // The steps that there are, from the one on that is being taken.
  begin(steps, from = 0) {
    Object.assign(this, { steps, at: from, begun: performance.now() });
    clearInterval(this.ticking);
    this.ticking = setInterval(() => this.write(), TICK);
    this.write();
  }

  // A step is done, by its number; it may have been done before.
  done(number) {
    if (number < this.at) return;
    Object.assign(this, { at: number + 1, begun: performance.now() });
    if (this.at >= this.steps.length) clearInterval(this.ticking);
    this.write();
  }

  get seconds() {
    return (performance.now() - this.begun) / 1000;
  }

  write() {
    const there = this.at < this.steps.length;
    this.bar.max = this.steps.length;
    this.bar.value = this.at;
    this.words.textContent = there ? stepWords(this.at + 1, this.steps.length, this.steps[this.at], this.seconds) : "";
    this.why.textContent = there && this.seconds > LONG ? FIRST : "";
  }
}

// How long something is waited for, behind what the status line says of it.
export class Waiting {
  constructor() {
    Object.assign(this, { ticking: 0, begun: 0 });
  }

  begin(words) {
    this.end();
    this.begun = performance.now();
    this.ticking = setInterval(() => {
      at("status").textContent = `${words} … ${Math.floor((performance.now() - this.begun) / 1000)} s`;
    }, 1000);
  }

  end() {
    clearInterval(this.ticking);
  }
}
