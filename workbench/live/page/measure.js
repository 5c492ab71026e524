// Distances: between two points that are clicked, or two things that are named; and a limit for them.

import { vec } from "/view/camera.js";
import { named, plain } from "/view/pick.js";
import { ask } from "./connection.js";
import { at, element } from "./elements.js";
import { signed } from "./rows.js";

const LINE = [232, 160, 19];
const AXES = [
  [206, 84, 20],
  [24, 128, 72],
  [44, 96, 214],
];

const mm = (metres) => signed(1000 * metres);

// The components of a way from one point to another, in words.
export function components(from, to) {
  const by = vec.sub(to, from);
  return ["x", "y", "z"].map((name, k) => `${name} ${by[k] < 0 ? "" : "+"}${mm(by[k])}`).join(", ");
}

// A line between two points, and its components one after the other along x, y and z.
export function dimensionLines(from, to) {
  const corners = [from, [to[0], from[1], from[2]], [to[0], to[1], from[2]], to];
  const steps = AXES.map((colour, k) => ({ from: corners[k], to: corners[k + 1], colour }));
  return [...steps, { from, to, colour: LINE }];
}

// What an option of the lists stands for, as the server takes it.
export function thingOf(value) {
  const [kind, ...names] = value.split("\t");
  return kind === "segment" ? { person: names[0], segment: names[1] } : { [kind]: names[0] };
}

export class Measure {
  // say: is told what is to be done, or went wrong.
  constructor(say) {
    Object.assign(this, { say, panel: null, first: null, found: null, generation: 0 });
    this.label = element("span", "", { hidden: true });
    at("pair").onsubmit = (event) => {
      event.preventDefault();
      this.ask();
    };
    at("pair-points").onclick = () => this.pick(at("pair-points").getAttribute("aria-pressed") !== "true");
    at("pair-ask").onclick = () => this.limit();
    at("measured-away").onclick = () => this.dismiss();
    document.addEventListener("chosen", (event) => this.choose(event), true);
    addEventListener("keydown", (event) => event.key === "Escape" && this.picking && this.pick(false), true);
  }

  // What there is to measure between.
  build({ roles, parts, controls, seats }) {
    const group = (label, rows) => {
      const made = element("optgroup", "", { label });
      made.append(...rows.map(([value, words]) => element("option", words, { value })));
      return made;
    };
    for (const id of ["pair-of", "pair-to"]) {
      const before = at(id).value;
      at(id).replaceChildren(
        ...roles.map((one) => group(one.role, one.segments.map((name) => [`segment\t${one.role}\t${name}`, `${one.role}: ${name}`]))),
        group("controls", controls.map((one) => [`control\t${one.name}`, plain(one.name)])),
        group("parts", [...parts, ...seats].map((name) => [`part\t${name}`, plain(name)])),
      );
      if (before) at(id).value = before;
      else if (id === "pair-to") at(id).selectedIndex = at(id).length - 1;
    }
    this.dismiss();
  }

  attach(panel) {
    this.panel = panel;
    panel.over.append(this.label);
    panel.viewer.addEventListener("frame", () => this.place());
    this.draw();
  }

  // Fill the form with a pair of the list of what is nearest.
  fill(pair) {
    at("pair-of").value = `segment\t${pair.person}\t${pair.segment}`;
    at("pair-to").value = pair.other ? `segment\t${pair.other}\t${pair.other_segment}` : `part\t${pair.target}`;
    at("pair-limit").focus();
    at("pair-limit").select();
    this.ask();
  }

  ask() {
    ask("measure", { of: thingOf(at("pair-of").value), to: thingOf(at("pair-to").value) });
  }

  // Make a criterion of the pair: its segment comes first.
  limit() {
    const things = [thingOf(at("pair-of").value), thingOf(at("pair-to").value)];
    things.sort((one, other) => Boolean(other.segment) - Boolean(one.segment));
    const [{ person, segment }, to] = things;
    const limit = at("pair-limit").valueAsNumber;
    if (!segment || to.control) return this.say("a criterion is about a segment of a person, and a part or somebody else", true);
    if (!Number.isFinite(limit)) return this.say("a limit in mm is needed", true);
    const other = to.part ? { part: to.part } : { other: to.person, other_segment: to.segment };
    ask("criterion", { person, segment, ...other, at_least: limit / 1000 }, true);
  }

  get picking() {
    return at("pair-points").getAttribute("aria-pressed") === "true";
  }

  pick(on) {
    at("pair-points").setAttribute("aria-pressed", String(on));
    this.first = null;
    this.say(on ? "click the first point in the picture; Esc ends" : "");
  }

  choose(event) {
    if (!this.picking || !event.detail) return;
    event.stopImmediatePropagation(); // nothing else is chosen
    const { point } = event.detail;
    const words = named(this.panel.scene, event.detail);
    if (!this.first) {
      this.first = { point, words };
      this.say(`from ${words}: click the second point`);
      return;
    }
    const { first } = this;
    this.pick(false);
    this.show({ of: first.words, to: words, points: [first.point, point], named: false });
  }

  // The answer to what was asked about two names.
  take(head) {
    this.show({ ...head, named: true });
  }

  // The state is another: what is measured between names is asked again.
  answered(head) {
    const changed = this.generation !== head.generation;
    this.generation = head.generation;
    if (changed && this.found?.named) this.ask();
  }

  show(found) {
    this.found = found;
    const [from, to] = found.points;
    const far = found.mm ?? 1000 * Math.hypot(...vec.sub(to, from));
    const size = `${signed(far)} mm`;
    const deep = far < 0 ? " (they overlap)" : far === 0 ? " (they touch or cross)" : "";
    this.label.textContent = size;
    at("measured-words").textContent = `${found.of} to ${found.to}: ${size}${deep}; ${components(from, to)} mm`;
    at("measured").hidden = false;
    this.draw();
  }

  dismiss() {
    this.found = null;
    at("measured").hidden = true;
    this.draw();
  }

  draw() {
    this.panel?.viewer.setMarks(this.found ? dimensionLines(...this.found.points) : [], "measure");
    this.place();
  }

  // The length stands beside the middle of its line.
  place() {
    if (!this.panel) return;
    const { camera, canvas } = this.panel.viewer;
    const middle = this.found && vec.mul(vec.add(...this.found.points), 0.5);
    const seen = middle && camera.project(middle);
    this.label.hidden = !seen;
    if (!seen) return;
    this.label.style.left = `${(0.5 + 0.5 * seen[0]) * canvas.clientWidth}px`;
    this.label.style.top = `${(0.5 - 0.5 * seen[1]) * canvas.clientHeight - 16}px`;
  }
}
