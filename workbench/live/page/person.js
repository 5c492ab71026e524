// The person who is chosen: size, clothes, harness zone, and postures by name or predicted.

import { plain } from "/view/pick.js";
import { ask } from "./connection.js";
import { at, element, options } from "./elements.js";
import { Size } from "./size.js";

const LIMBS = ["left hand", "right hand", "left foot", "right foot"];
const POINTS = ["eyes", "heels"];
// What a harness zone means in a seat, and for who stands, whom no harness holds.
const ZONES = {
  seated: ["Harness in verdicts of reach", "locked, no stretch", "locked, shoulder stretched", "unlocked"],
  stands: ["What moves in verdicts of reach", "the arm", "the arm and the shoulder", "bends and steps"],
};
const id = (name) => `predict-${name.replace(" ", "-")}`;

export class Person {
  // state: hello, answer and the number of the person.
  constructor(state) {
    this.state = state;
    this.size = new Size(() => this.role);
    this.known = "";
    at("harness").onchange = () => {
      const zone = Number(at("harness").value);
      ask("harness", { person: this.role, ...(zone > 0 ? { zone } : {}) });
    };
    at("posture-form").onsubmit = (event) => {
      event.preventDefault();
      const name = at("posture-name").value;
      if (name) ask("posture", { person: this.role, name });
    };
    at("mirror").onclick = () => ask("mirror", { person: this.role });
    at("free").onclick = () => ask("free", { person: this.role });
    at("predict").onsubmit = (event) => {
      event.preventDefault();
      this.predict();
    };
  }

  get offers() {
    return this.state.hello.people[this.state.person];
  }

  get role() {
    return this.offers.role;
  }

  // What this person may be given.
  build() {
    at("who").hidden = !this.offers; // a study of motions alone has nobody to be changed
    if (!this.offers) return;
    const { many, wearable, postures, reaches, seat, stands } = this.offers;
    const { controls, points } = this.state.hello;
    at("size").hidden = at("clothes").hidden = many;
    at("many").hidden = !many;
    at("harness-row").hidden = !reaches;
    const [title, ...zones] = ZONES[stands ? "stands" : "seated"];
    at("harness-words").textContent = title;
    zones.forEach((zone, k) => (at("harness").querySelector(`[value="${k + 1}"]`).textContent = `${k + 1}: ${zone}`));
    at("posture-form").hidden = !postures.length;
    at("prediction").hidden = !seat || !postures.length;
    this.clothes = wearable.map((name) => {
      const label = element("label");
      const input = element("input", "", { type: "checkbox", value: name });
      input.onchange = () => this.dress();
      label.append(input, ` ${plain(name)}`);
      return { name, label, input };
    });
    at("clothes").replaceChildren(element("legend", "Clothes"), ...this.clothes.map(({ label }) => label));
    if (!wearable.length) at("clothes").hidden = true;
    options(at("posture-name"), ["", ...postures]);
    Object.assign(at("posture-name").options[0], { textContent: "predicted", hidden: true });
    options(at("predict-like"), postures);
    const foot = (one) => one.grip === "foot";
    for (const limb of LIMBS) {
      const fit = controls.filter((one) => foot(one) === limb.endsWith("foot")).map((one) => one.name);
      options(at(id(limb)), ["", ...fit]);
    }
    for (const name of POINTS) options(at(id(name)), ["", ...points]);
    this.known = "";
    if (this.state.answer) this.show();
  }

  // always: also what somebody is at.
  show(always = false) {
    const now = this.state.answer.people[this.state.person];
    if (!now) return;
    this.size.show(now);
    this.clothes.forEach(({ name, input }) => (input.checked = now.clothes.includes(name)));
    at("harness").value = String(now.zone);
    at("free").disabled = now.free || !now.predicted;
    const kind = now.drives ? "a driver's, predicted" : now.predicted ? "predicted" : `given: ${plain(now.posture)}`;
    const hands = Object.entries(now.hands).map(([hand, control]) => `${hand} on ${plain(control)}`);
    at("posture-now").textContent = [kind, ...hands, ...(now.free ? [this.offers.stands ? "free to step" : "the seat is free"] : [])].join("; ");
    const known = JSON.stringify([this.state.person, now.posture, now.prediction]);
    if (known === this.known || (!always && at("predict").contains(document.activeElement))) return;
    this.known = known;
    at("posture-name").value = now.posture; // "" where it is predicted
    at("predict-like").value = now.prediction.like;
    for (const limb of LIMBS) at(id(limb)).value = now.prediction.holds[limb] ?? "";
    for (const name of POINTS) at(id(name)).value = now.prediction[name];
  }

  // What was asked is refused: what holds is shown again.
  restore() {
    const now = this.state.answer.people[this.state.person];
    if (!now) return;
    this.size.restore(now);
    this.known = "";
    this.show(true);
  }

  // Put on what was ticked; what is worn stays in its order.
  dress() {
    const worn = this.state.answer.people[this.state.person].clothes;
    const ticked = this.clothes.filter(({ input }) => input.checked).map(({ name }) => name);
    const strange = worn.filter((name) => !this.clothes.some((one) => one.name === name));
    const kept = worn.filter((name) => ticked.includes(name) || strange.includes(name));
    const clothes = [...kept, ...ticked.filter((name) => !kept.includes(name))];
    ask("clothes", { person: this.role, clothes });
  }

  // What mends how somebody holds and sits: a prediction from what is suggested; all cases where the seat goes along.
  mend({ role, offer, prediction }) {
    this.predictAs(role, prediction, { free: offer === "free" });
  }

  predict() {
    const chosen = (names) => Object.fromEntries(names.map((name) => [name, at(id(name)).value]));
    const wanted = { like: at("predict-like").value, holds: chosen(LIMBS), ...chosen(POINTS) };
    this.predictAs(this.role, wanted, { everywhere: at("predict-everywhere").checked, free: at("predict-free").checked });
  }

  predictAs(person, { like, holds, eyes, heels }, how) {
    const held = Object.entries(holds).filter(([, control]) => control);
    ask("predict", { person, like, holds: Object.fromEntries(held), ...(eyes && { eyes }), ...(heels && { heels }), ...how });
  }
}
