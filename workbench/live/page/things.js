// Parts and controls that can be moved: which one is chosen, and by how much it stands elsewhere.

import { plain } from "/view/pick.js";
import { ask, waits } from "./connection.js";
import { at, element } from "./elements.js";

const AXES = ["x", "y", "z"];

export class Things {
  // say: is told what is wrong with what was typed.
  constructor(say) {
    this.say = say;
    this.answer = null;
    this.held = false;
    at("thing-name").onchange = () => this.taken();
    for (const name of AXES) {
      at(`thing-${name}`).oninput = () => this.ask(false);
      at(`thing-${name}`).onchange = () => this.ask(true);
    }
    at("thing").onsubmit = (event) => event.preventDefault();
    at("thing-back").onclick = () => this.move([0, 0, 0], true);
  }

  // What there is: controls first, a part under each name of its own.
  build({ controls, parts }) {
    const group = (label, kind, names) => {
      const made = element("optgroup", "", { label });
      const rows = names.map((name) => element("option", plain(name), { value: `${kind} ${name}` }));
      made.append(...rows);
      return made;
    };
    const before = at("thing-name").value;
    at("thing-name").replaceChildren(
      group("controls", "controls", controls.map((one) => one.name)),
      group("parts with their controls", "parts", parts),
    );
    if (before) at("thing-name").value = before;
    this.controls = controls;
  }

  // { kind, name } of what is chosen.
  get chosen() {
    const [kind, ...name] = at("thing-name").value.split(" ");
    return { kind, name: name.join(" ") };
  }

  choose(kind, name) {
    at("thing-name").value = `${kind} ${name}`;
    this.taken();
  }

  // Something else is chosen: the bench makes ready for its drag.
  taken() {
    const { kind, name } = this.chosen;
    this.held = false;
    this.write();
    if (name) ask("ready", { [kind]: [name] });
  }

  // [m] by how much the chosen thing stands elsewhere by what is said of it alone.
  get by() {
    const { kind, name } = this.chosen;
    const rows = this.answer?.moves ?? [];
    return rows.find((row) => row[kind]?.length === 1 && row[kind][0] === name)?.by ?? this.shared(kind, name);
  }

  // [m] of a thing that was moved together with others.
  shared(kind, name) {
    return (this.answer?.moves ?? []).find((row) => row[kind]?.includes(name))?.by ?? [0, 0, 0];
  }

  show(head) {
    this.answer = head;
    if (this.held && waits()) return;
    this.held = false;
    this.write();
  }

  write() {
    const by = this.by;
    AXES.forEach((name, k) => (at(`thing-${name}`).value = (1000 * by[k]).toFixed(1)));
    at("thing-back").disabled = !by.some(Boolean);
  }

  ask(done) {
    this.held = true;
    const by = AXES.map((name) => at(`thing-${name}`).valueAsNumber / 1000);
    if (by.every(Number.isFinite)) return this.move(by, done);
    if (!done) return; // it is being typed
    this.restore();
    this.say("a number of mm is needed", true);
  }

  // What was asked is refused: what holds is shown again.
  restore() {
    this.held = false;
    if (this.answer) this.write();
  }

  move(by, done) {
    const { kind, name } = this.chosen;
    if (name) ask("move", { [kind]: [name], by, done });
  }
}
