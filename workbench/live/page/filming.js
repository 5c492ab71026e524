// A film of what is shown: of a motion, or once round a posture, from where the page looks. The server draws it.

import { ask } from "./connection.js";
import { download, fileName } from "./copying.js";

// What of a picture's section the film has: axis, side and place, null for none.
export function planeOf(section) {
  if (!section) return null;
  const axis = [0, 1, 2].findIndex((k) => section[k]);
  return [axis, Math.sign(section[axis]), -section[3] / section[axis]];
}

export class Filming {
  // motion: gives the name of the motion that is shown, "" where none is; eyes: gives the role through whose eyes the
  // picture is seen, "" for none; names: gives the words that name what is shown; say: is told how far the film is.
  constructor({ motion, eyes, names, say }) {
    Object.assign(this, { motion, eyes, names, say, panel: null, making: null });
  }

  attach(panel) {
    this.panel = panel;
    this.button = panel.button("film", () => this.toggle());
    this.button.title = "M: film the motion, or once round";
    panel.bar.querySelector(".space").before(this.button);
    this.write();
  }

  toggle() {
    if (this.making) return ask("film_end");
    if (!this.panel) return this.say("there is no picture to film", true);
    this.making = this.names().slice(0, 2); // the time of a motion is no part of its film
    this.write();
    return ask("film", this.wanted(this.panel));
  }

  wanted({ viewer, scene }) {
    const { camera, canvas, section, hiddenParts, hiddenBodies } = viewer;
    const named = (rows, hidden) => [...hidden].filter((k) => rows[k]).map((k) => rows[k].name);
    return {
      case: this.motion() || null,
      eye: camera.eye(),
      at: camera.at,
      angle: camera.angle,
      width: Math.round(canvas.clientWidth),
      height: Math.round(canvas.clientHeight),
      eyes: this.eyes() || null,
      hidden: named(scene.place?.parts ?? [], hiddenParts),
      without: named(scene.bodies, hiddenBodies),
      section: planeOf(section),
    };
  }

  // How far it is, that it is there, or that it has ended.
  take({ done, of, file, frames, ending }) {
    if (!this.making) return;
    if (done) return this.say(`film: frame ${done} of ${of}; M or the button ends it`);
    const name = fileName(this.making, ending?.slice(1));
    this.forget();
    if (!file) return this.say("the film was ended, nothing is kept of it");
    download(`/film/${file}`, name);
    return this.say(`a film of ${frames} frames: downloaded as ${name}`);
  }

  // What was asked is refused, or the bench has been started anew.
  forget() {
    this.making = null;
    this.write();
  }

  write() {
    if (this.button) this.button.textContent = this.making ? "end film" : "film";
  }
}
