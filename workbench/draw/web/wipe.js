// Two states of what is shown in one picture: the first to the left of a line, the second to its
// right, and the slider that moves the line.

import { element } from "./list.js";

// Whether a body, a part or a mark is there in a state: what has none is in both.
export function isOf(thing, state) {
  return (thing.state ?? state) === state;
}

// The state at a place across the picture, from 0 at the left to 1 at the right.
export function stateAt(wipe, across) {
  return across < wipe ? 0 : 1;
}

// The states that are seen, each from one pixel to another of a picture this wide.
export function stripes(wipe, width) {
  const line = Math.round(wipe * width);
  return [
    { state: 0, from: 0, to: line },
    { state: 1, from: line, to: width },
  ].filter(({ from, to }) => to > from);
}

// What the slider says.
export function wipeWords([before, after], wipe) {
  if (wipe <= 0) return `${after} alone`;
  if (wipe >= 1) return `${before} alone`;
  return `${before} to the left of ${Math.round(100 * wipe)} %, ${after} to the right`;
}

export class Wipe {
  // names of the two states; show: is given the place of the line, from 0 to 1.
  constructor(names, show) {
    Object.assign(this, { names, show });
    this.slider = element("input", { type: "range", min: 0, max: 100, value: 50 });
    this.slider.setAttribute("aria-label", `wipe between ${names[0]} and ${names[1]}`);
    this.slider.oninput = () => this.at(Number(this.slider.value) / 100);
    const end = (words, wipe) => {
      const button = element("button", { type: "button", textContent: words, onclick: () => this.at(wipe) });
      button.setAttribute("aria-label", wipeWords(names, wipe));
      return button;
    };
    this.bar = element("div", { className: "wipe" }, this.slider, end(`◧ ${names[0]}`, 1), end(`${names[1]} ◨`, 0));
    this.line = element("div", { className: "line" });
  }

  at(wipe) {
    this.slider.value = Math.round(100 * wipe);
    this.slider.setAttribute("aria-valuetext", wipeWords(this.names, wipe));
    this.line.hidden = wipe <= 0 || wipe >= 1;
    this.line.style.left = `${100 * wipe}%`;
    this.show(wipe);
  }
}
