// The sliders of the person who is chosen: the seat within its travel, the joints with their stops.

import { plain } from "/view/pick.js";
import { ask, waits } from "./connection.js";
import { at, element } from "./elements.js";
import { signed } from "./rows.js";

const STEP = 0.1;
const BIG = 10; // steps of a key with shift
const REST = 250; // milliseconds without another key after which an adjustment is set

export class Sliders {
  // state: hello, answer and the number of the person.
  constructor(state) {
    Object.assign(this, { state, rows: [], set: new Map(), held: null, letGo: false, pending: null });
    addEventListener("keydown", (event) => event.key === "Escape" && this.held && !this.letGo && this.drop(), true);
  }

  // A drag is given up: what was there before is shown again.
  drop() {
    this.held = null;
    ask("drop");
  }

  // The sliders of the person who is chosen.
  build() {
    const person = this.state.hello.people[this.state.person];
    this.rows = [];
    at("seat").replaceChildren();
    at("joints").replaceChildren();
    if (!person) return;
    if (person.seat) ["forward", "up"].forEach((way) => this.seat(person, way));
    person.joints.forEach((joint, j) => joint.axes.some(Boolean) && this.joint(person, joint, j));
    if (this.state.answer) this.show();
  }

  seat(person, way) {
    const made = this.slider(`seat ${way}`, "mm", (mm, done) => {
      const now = this.state.answer.people[this.state.person];
      ask("seat", { person: person.role, forward: now.forward, up: now.up, [way]: mm / 1000, done });
    });
    const [low, high] = person.seat[way].map((metres) => 1000 * metres);
    this.rows.push((now) => made.show(1000 * now[way], low, high));
    at("seat").append(made.row);
  }

  joint(person, joint, j) {
    const group = element("fieldset");
    group.append(element("legend", joint.name));
    joint.axes.forEach((motions, axis) => {
      if (!motions) return;
      const made = this.slider(`${motions[0]} / ${motions[1]}`, "°", (degrees, done) =>
        ask("joint", { person: person.role, joint: joint.joint, axis, degrees, done }),
      );
      this.rows.push((now) => {
        const [up, down] = now.limits[j][axis];
        made.show(now.angles[j][axis], -down, up, Math.max(-180, -down - 10), Math.min(180, up + 10));
      });
      group.append(made.row);
    });
    at("joints").append(group);
  }

  // What of the environment may be adjusted, asked for once a slider is let go.
  adjustments(found) {
    if (found.map((one) => one.name).join() !== [...this.set.keys()].join()) {
      const made = found.map(({ name, unit, scale }) => {
        let resting = 0; // its own: another slider takes nothing away that was set here
        const send = (value, done) => {
          if (!done) return;
          this.pending = { name, value }; // takes a second: answers until then are of an earlier state
          clearTimeout(resting);
          resting = setTimeout(() => ask("adjust", { name, value: value / scale }, name), REST);
        };
        return [name, this.slider(plain(name), unit, send)];
      });
      this.set = new Map(made);
      at("adjustments").replaceChildren(...made.map(([, { row }]) => row));
    }
    for (const { name, at: value, travel, by } of found) {
      if (this.pending?.name === name && Math.abs(this.pending.value - value) > 0.06) continue;
      if (this.pending?.name === name) this.pending = null;
      const { row, show } = this.set.get(name);
      show(value, ...travel);
      row.title = by ? `set by ${by}, until it is set here` : "";
    }
  }

  // A slider with its number: { row, show(number, low, high, from, to) }, which may go from and to
  // farther than its stops low and high; send: is given a number and whether it is let go.
  slider(words, unit, send) {
    const row = element("label", "", { className: "slider" });
    const input = element("input", "", { type: "range", step: String(STEP) });
    input.setAttribute("aria-label", words);
    const value = element("output", "", { ariaLive: "off" }); // the slider says its value itself
    input.oninput = () => {
      this.held = input;
      this.letGo = false;
      value.textContent = `${signed(Number(input.value))} ${unit}`;
      input.setAttribute("aria-valuetext", value.textContent);
      send(Number(input.value), false);
    };
    input.onchange = () => {
      this.held = input;
      this.letGo = true; // shown anew once the answer to this is there
      send(Number(input.value), true);
    };
    input.onkeydown = (event) => bigStep(event, input);
    row.append(element("span", words), input, value);
    const show = (number, low, high, from = low, to = high) => {
      if (this.held === input) return;
      input.min = Math.min(from, number);
      input.max = Math.max(to, number);
      input.value = number;
      value.textContent = `${signed(number)} ${unit}`;
      const beyond = Math.max(number - high, low - number);
      row.classList.toggle("beyond", beyond > 0.05);
      const over = beyond > 0.05 ? `; ${beyond.toFixed(1)} beyond the stop` : "";
      input.setAttribute("aria-valuetext", `${signed(number)} ${unit}${over}`);
    };
    return { row, show };
  }

  show() {
    if (this.letGo && !waits()) this.held = null;
    this.adjustments(this.state.answer.adjustments);
    const now = this.state.answer.people[this.state.person];
    if (now) this.rows.forEach((show) => show(now));
  }

  // What was asked is refused: what holds is shown again.
  restore() {
    this.held = this.pending = null;
    this.show();
  }
}

// Ten steps for an arrow with shift.
function bigStep(event, input) {
  const sense = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (!event.shiftKey || !sense) return;
  event.preventDefault();
  input.value = Number(input.value) + sense * BIG * STEP;
  for (const name of ["input", "change"]) input.dispatchEvent(new Event(name));
}
