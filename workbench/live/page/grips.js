// What is dragged in the picture: the hand or foot, the seat, the part or control that is chosen.

import { vec } from "/view/camera.js";
import { ask } from "./connection.js";
import { at, options } from "./elements.js";
import { Gizmo } from "./gizmo.js";

const WORLD = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const LIMBS = { hand: "hand|thumb|finger|lower arm|upper arm", foot: "foot|lower leg|upper leg" };
const ENDS = { "right hand": /right (hand|thumb|finger)/, "left hand": /left (hand|thumb|finger)/, "right foot": /right foot/, "left foot": /left foot/ };

export class Grips {
  // state: hello, answer and the number of the person; things: the panel of parts and controls.
  constructor(state, things, choosePerson) {
    Object.assign(this, { state, things, choosePerson, panel: null, middles: new Map() });
    this.gizmo = new Gizmo(() => ask("drop"));
    document.querySelectorAll("input[name=grip]").forEach((input) => (input.onchange = () => this.show()));
    at("limb-name").addEventListener("change", () => this.take("limb"));
    at("limb-name").addEventListener("change", () => this.showTip());
    at("thing-name").addEventListener("change", () => this.take("thing"));
    document.addEventListener("chosen", (event) => this.choose(event.detail));
    at("limb").onsubmit = (event) => {
      event.preventDefault();
      const control = at("limb-control").value;
      const target = ["x", "y", "z"].map((name) => Number(at(`limb-${name}`).value) / 1000);
      this.reach(control ? { control } : { target });
    };
  }

  attach(panel) {
    this.panel = panel;
    this.middles.clear();
    this.gizmo.attach(panel);
  }

  get person() {
    return this.state.answer.people[this.state.person];
  }

  get chosen() {
    return document.querySelector("input[name=grip]:checked")?.value ?? "";
  }

  take(name) {
    const input = document.querySelector(`input[name=grip][value=${name}]`);
    if (!input.disabled) input.checked = true;
    this.show();
  }

  show() {
    if (!this.state.answer) return;
    const still = this.person && !this.state.motion.there;
    const seat = still ? this.state.hello.people[this.state.person].seat : null;
    const names = still ? Object.keys(this.person.tips) : [];
    const limb = at("limb-name");
    at("limb").hidden = !names.length;
    if ([...limb.options].map((one) => one.value).join() !== names.join()) options(limb, names);
    document.querySelector("input[name=grip][value=seat]").disabled = !seat;
    document.querySelector("input[name=grip][value=limb]").disabled = !names.length;
    const { activeElement } = document;
    const typed = at("limb").contains(activeElement) && activeElement.type === "number";
    if (!typed) this.showTip();
    const grip = { limb: () => this.limb(), seat: () => this.seat(seat), thing: () => this.thing() }[this.chosen];
    this.gizmo.aim(grip ? grip() : null, this.crosses());
    this.panel?.viewer.setThrough(this.through());
  }

  // The spheres of the limb that is chosen; null where none is.
  through() {
    const body = this.panel.scene.bodies[this.state.person];
    if (this.chosen !== "limb" || !body) return null;
    const [side, end] = at("limb-name").value.split(" ");
    const limb = new RegExp(`^${side} (${LIMBS[end]})`);
    return { body: this.state.person, ranges: rangesOf(body.segment, (k) => limb.test(body.segments[k])) };
  }

  showTip() {
    const tip = this.state.answer && this.person?.tips[at("limb-name").value];
    ["x", "y", "z"].forEach((name, k) => tip && (at(`limb-${name}`).value = (1000 * tip[k]).toFixed(1)));
  }

  // The places of controls that are off their parts.
  crosses() {
    const { hello, answer } = this.state;
    const alone = answer.moves.flatMap((move) => move.controls);
    return hello.controls.flatMap((one, k) => (alone.includes(one.name) ? [answer.controls[k]] : []));
  }

  reach(goal, done = true) {
    const person = this.state.hello.people[this.state.person].role;
    ask("hand", { person, limb: at("limb-name").value, obstacles: at("limb-obstacles").checked, done, ...goal });
  }

  limb() {
    if (this.state.motion.there) return null;
    const tip = this.person?.tips[at("limb-name").value];
    if (!tip) return null;
    return { at: tip, axes: WORLD, free: true, drag: (by, done) => this.reach({ target: vec.add(tip, by) }, done) };
  }

  seat(seat) {
    if (!seat) return null;
    const now = this.person;
    const { role } = this.state.hello.people[this.state.person];
    const within = (value, [low, high]) => Math.max(low, Math.min(high, value));
    const drag = (by, done) => {
      const forward = within(now.forward + vec.dot(by, seat.ahead), seat.forward);
      ask("seat", { person: role, forward, up: within(now.up + by[2], seat.up), done });
    };
    const middle = this.middle(seat.parts);
    return middle && { at: middle, axes: [seat.ahead, [0, 0, 1]], free: false, drag };
  }

  thing() {
    const { kind, name } = this.things.chosen;
    const by = this.things.by;
    const control = this.state.hello.controls.findIndex((one) => one.name === name);
    const middle = kind === "controls" ? this.state.answer.controls[control] : this.middle([name]);
    if (!middle) return null;
    return { at: middle, axes: WORLD, free: true, drag: (way, done) => this.things.move(vec.add(by, way), done) };
  }

  // The middle of the boxes of some parts where they are now; null without a picture.
  middle(names) {
    const place = this.panel?.scene.place;
    if (!place) return null;
    const shift = this.state.answer.shifts[names[0]] ?? [0, 0, 0];
    const key = names.join("\n");
    if (!this.middles.has(key)) this.middles.set(key, middleOf(place, names));
    const found = this.middles.get(key);
    return found && vec.add(found, shift);
  }

  // Something was clicked in the picture.
  choose(hit) {
    if (!hit || !this.state.answer) return;
    const { hello } = this.state;
    if (hit.kind === "part") {
      const { name } = this.panel.scene.place.parts[hit.part];
      const sitter = hello.people.findIndex((one) => one.seat?.parts.includes(name));
      if (sitter >= 0) {
        this.choosePerson(sitter);
        this.take("seat");
      } else if (hello.parts.includes(name)) {
        this.things.choose("parts", name);
        this.take("thing");
      }
      return;
    }
    if (this.state.motion.there) return;
    this.choosePerson(hit.body);
    const body = this.panel.scene.bodies[hit.body];
    const segment = body.segments[body.segment[hit.sphere]];
    const limb = Object.keys(this.person.tips).find((name) => ENDS[name].test(segment));
    if (!limb) return;
    at("limb-name").value = limb;
    this.showTip();
    this.take("limb");
  }
}

// The runs of spheres whose segments are meant: [[from, to]], each without its last.
export function rangesOf(segment, meant) {
  const ranges = [];
  segment.forEach((k, s) => {
    if (!meant(k)) return;
    if (ranges.length && ranges[ranges.length - 1][1] === s) ranges[ranges.length - 1][1] = s + 1;
    else ranges.push([s, s + 1]);
  });
  return ranges;
}

function middleOf(place, names) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const mine = place.parts.map((part) => names.includes(part.name));
  place.part.forEach((part, k) => {
    if (!mine[part]) return;
    for (let i = 0; i < 3; i++) {
      low[i] = Math.min(low[i], place.vertices[3 * k + i]);
      high[i] = Math.max(high[i], place.vertices[3 * k + i]);
    }
  });
  return Number.isFinite(low[0]) ? low.map((value, i) => (value + high[i]) / 2) : null;
}
