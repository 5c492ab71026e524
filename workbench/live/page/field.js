// The field of view of who is looked through: how eyes and head are turned, what hides how much of it, a picture.

import { vec } from "/view/camera.js";
import { ask } from "./connection.js";
import { at, element } from "./elements.js";

const REST = 250; // milliseconds without a turn after which it is counted finely
const percent = (share) => `${share.toFixed(1)} %`;

// A turn to the left and up [degrees], in words.
export function turnWords([left, up]) {
  const side = Math.abs(left) < 0.5 ? "" : `${Math.abs(left).toFixed(0)}° ${left > 0 ? "left" : "right"}`;
  const rise = Math.abs(up) < 0.5 ? "" : `${Math.abs(up).toFixed(0)}° ${up > 0 ? "up" : "down"}`;
  return [side, rise].filter(Boolean).join(", ") || "straight ahead";
}

// Where somebody looks, in words.
export function gazeWords({ eyes, head, trunk, lack }) {
  const bends = trunk ? `; trunk ${turnWords([trunk, 0])}` : "";
  const words = `Eyes ${turnWords(eyes)} in the head; head ${turnWords(head)}${bends}`;
  return lack ? `${words}: ${lack.toFixed(0)}° beyond the turn of ${trunk ? "eyes, head and trunk" : "eyes and head"}` : words;
}

// What is free of a field, in words.
export function freeWords({ free, error, fine }) {
  const [left, right, either, both] = free.map(percent);
  const coarse = fine ? "" : ", while it turns at 0.5°";
  return `Free: ${both} to both eyes, ${either} to one at least, ${left} to the left, ${right} to the right (± ${error.toFixed(1)} points${coarse})`;
}

export class Field {
  // eye: whose view it is of, see eye.js; state: has the answer that is shown.
  constructor(eye, state) {
    Object.assign(this, { eye, state, asked: "", head: null });
    at("field-within").onchange = () => this.look();
    eye.shown = () => this.look();
  }

  // The eyes, the state or the field have changed: ask what is seen. A motion has no field.
  look(fine = false) {
    const { set, panel } = this.eye;
    const there = Boolean(set) && !panel.film;
    at("field").hidden = !there;
    if (!there) {
      this.asked = "";
      return;
    }
    const { z } = panel.viewer.camera.axes();
    const given = { person: set.role, toward: vec.mul(z, -1), within: Number(at("field-within").value), fine };
    const asked = JSON.stringify([given.person, given.toward, given.within, this.state.answer?.generation]);
    if (fine !== (asked === this.asked)) return; // asked already, or turned since
    this.asked = asked;
    clearTimeout(this.rests);
    if (!fine) this.rests = setTimeout(() => this.look(true), REST);
    ask("field", given, "field");
  }

  // Another state is answered: what is known of the one before is grey until it is looked at.
  answered({ generation }) {
    at("field").classList.toggle("waiting", generation !== this.head?.generation);
    this.look();
  }

  take({ head, arrays }) {
    const { set, panel } = this.eye;
    if (!set || head.person !== set.role) return;
    this.head = head;
    at("field").classList.toggle("waiting", head.generation !== this.state.answer?.generation);
    at("field-title").textContent = `Field of view of ${head.person}`;
    at("field-gaze").textContent = head.words || gazeWords(head);
    at("field-free").textContent = head.words ? "" : freeWords(head);
    at("field-figures").hidden = Boolean(head.words);
    if (head.words) return;
    at("field-rows").replaceChildren(...head.rows.map(fieldRow));
    at("field-more").textContent = head.more ? `${head.more} more hide less` : "";
    this.paint(head, arrays.picture);
    if (!panel.film) this.eye.turn(head.at, arrays.centres);
  }

  paint({ size, rows, within }, picture) {
    const canvas = at("field-picture");
    canvas.width = canvas.height = size;
    const image = new ImageData(size, size);
    for (let k = 0; k < size * size; k += 1) {
      for (let c = 0; c < 3; c += 1) image.data[4 * k + c] = picture[3 * k + c];
      image.data[4 * k + 3] = 255;
    }
    canvas.getContext("2d").putImageData(image, 0, 0);
    const most = rows.slice(0, 3).map((row) => `${row.name} ${percent(row.shares[2])}`).join(", ");
    const around = within === 180 ? "all round" : `within ${within}° of the line of sight`;
    canvas.setAttribute("aria-label", `What hides the field ${around}: ${most || "nothing"}`);
  }
}

function fieldRow({ name, colour, shares, error }) {
  const row = element("tr");
  const cell = element("th", "", { scope: "row" });
  const swatch = element("span", "", { className: "swatch" });
  swatch.style.background = `rgb(${colour.join(" ")})`;
  cell.append(swatch, ` ${name}`);
  const [left, right, either, both] = shares;
  const cells = [both, either, left, right].map((share) => element("td", share.toFixed(1), { className: "number" }));
  cells[0].title = cells[1].title = `± ${error.toFixed(1)} points`;
  row.append(cell, ...cells);
  return row;
}
