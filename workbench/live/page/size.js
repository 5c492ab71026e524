// The size of the person who is chosen: sex, age, and measures in mm or as percentiles.

import { plain } from "/view/pick.js";
import { ask } from "./connection.js";
import { at, element } from "./elements.js";

const ALWAYS = ["stature", "sitting_height", "mass"];
const unit = (name) => (name === "mass" ? "kg" : "mm");
const scale = (name) => (name === "mass" ? 1 : 1000);

// The rows of the form: those that are always there, then what else the study states.
export const rowsOf = (size) => [...new Set([...ALWAYS, ...Object.keys(size?.measures ?? {})])];

// What is asked of the bench. fields: by measure { value, percentile } as they stand in the form, "" for
// nothing; changed: the measure whose percentile was changed, "" for none.
export function wanted({ sex, age, fields }, changed = "") {
  const found = { sex, measures: {}, percentiles: {} };
  if (!sex) return {};
  if (age !== "") found.age = Number(age);
  for (const [name, { value, percentile }] of Object.entries(fields)) {
    if (name === changed && percentile !== "") found.percentiles[name] = Number(percentile);
    else if (name === "mass" && value !== "") found.mass = Number(value);
    else if (value !== "") found.measures[name] = Number(value) / scale(name);
  }
  const stated = Object.keys(found.measures).length + Object.keys(found.percentiles).length;
  if (!stated && age === "") found.percentiles.stature = 50; // a sex alone: somebody in the middle
  return found;
}

export class Size {
  // role: gives the name of the person.
  constructor(role) {
    this.role = role;
    this.rows = new Map();
    this.held = false;
    at("size-sex").onchange = () => this.ask();
    at("size-age").onchange = () => this.ask();
    at("size").onsubmit = (event) => event.preventDefault();
  }

  // What was asked is refused: what holds is shown again.
  restore(person) {
    this.held = false;
    this.show(person, true);
  }

  row(name) {
    const field = (label, change) => {
      const input = element("input", "", { type: "number", step: "any", min: 0 });
      input.setAttribute("aria-label", label);
      input.oninput = () => (this.held = true);
      input.onchange = change;
      return input;
    };
    const value = field(`${plain(name)} in ${unit(name)}`, () => this.ask());
    const percentile = field(`${plain(name)}, percentile`, () => this.ask(name));
    percentile.max = 100;
    const row = element("tr");
    const cells = [element("th", plain(name), { scope: "row" }), element("td"), element("td")];
    cells[1].append(value, ` ${unit(name)}`);
    cells[2].append(percentile, " %");
    row.append(...cells);
    return { row, value, percentile };
  }

  show({ size }, always = false) {
    if (!always && this.held && at("size").contains(document.activeElement)) return; // it is being typed
    this.held = false;
    const names = rowsOf(size);
    if (names.join() !== [...this.rows.keys()].join()) {
      this.rows = new Map(names.map((name) => [name, this.row(name)]));
      at("size-rows").replaceChildren(...[...this.rows.values()].map(({ row }) => row));
    }
    at("size-sex").value = size?.sex ?? "";
    at("size-age").value = size?.age ?? "";
    at("size-age").disabled = at("size-table").hidden = !size;
    for (const [name, { value, percentile }] of this.rows) {
      const [given, rank] = size?.measures[name] ?? [null, null];
      value.value = given === null ? "" : Math.round(10 * scale(name) * given) / 10;
      percentile.value = rank === null ? "" : rank.toFixed(1);
    }
  }

  ask(changed = "") {
    const fields = {};
    for (const [name, { value, percentile }] of this.rows) {
      fields[name] = { value: value.value, percentile: percentile.value };
    }
    this.held = false;
    const form = { sex: at("size-sex").value, age: at("size-age").value, fields };
    ask("size", { person: this.role(), ...wanted(form, changed) });
  }
}
