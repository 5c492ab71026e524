// Seats, controls and points in numbers, each of which can be typed over.

import { plain } from "/view/pick.js";
import { at, element, options, put, refuse, sendTyped } from "./elements.js";

const TRAVEL = { forward: "travel forward", up: "travel up" };
const ANGLES = { cushion_angle: "cushion, front up", back_angle: "back, aft of upright", yaw: "turned to the left" };

export class Things {
  // each: asks something of the bench.
  // chosen: the parts that are chosen.
  constructor(each, chosen) {
    Object.assign(this, { each, chosen, rows: new Map(), hello: null });
  }

  show(head, hello) {
    this.hello = hello;
    const seats = head.seats.map((one) => {
      const { doubts = [], notes = [] } = head.seated[one.name] ?? {};
      return { ...one, doubts: [...one.doubts, ...doubts], notes: [...one.notes, ...notes] };
    });
    this.list("seats", "seat", seats, (one) => this.seat(one), "Pick a cushion and a back in the picture.");
    this.list("controls", "control", head.controls, (one) => this.control(one), "Pick them in the picture.");
    this.list("points", "point", head.points, (one) => this.point(one), "Design eyes, heels, balls of the feet.");
    const names = (rows) => rows.map(({ name }) => element("option", "", { value: name }));
    at("seat-names").replaceChildren(...names(head.seats));
    at("control-names").replaceChildren(...names(head.controls));
  }

  // Rows by their names: one that is there is shown anew, so that the focus stays.
  list(id, kind, things, make, none) {
    const rows = things.map((one) => {
      const key = `${kind} ${one.name} ${one.there ?? ""}`;
      if (!this.rows.has(key)) this.rows.set(key, make(one));
      const row = this.rows.get(key);
      row.show(one);
      return row.made;
    });
    const place = at(id);
    const there = rows.length ? rows : [element("p", none, { className: "none" })];
    if (there.length !== place.children.length || there.some((one, k) => one !== place.children[k])) place.replaceChildren(...there);
  }

  // Number fields of one figure; scale: of what is shown in what is sent.
  fields(kind, name, figure, count, scale, step) {
    const words = plain(figure);
    const made = element("span", "", { className: "numbers" });
    const inputs = Array.from({ length: count }, (_, k) => {
      const input = element("input", "", { type: "number", step });
      input.setAttribute("aria-label", `${name}: ${words}${count > 1 ? ` ${k + 1}` : ""}`);
      input.onchange = () => {
        const values = inputs.map((one) => Number((one.valueAsNumber * scale).toPrecision(12)));
        if (!values.every(Number.isFinite)) return refuse(input, "a number is needed");
        const value = count > 1 ? values : values[0];
        return sendTyped(input, (then) => this.each("figure", { kind, name, figure, value }, then));
      };
      made.append(input, " ");
      return input;
    });
    const show = (value) => [value].flat().forEach((one, k) => put(inputs[k], Number((one / scale).toFixed(1))));
    return { made, show };
  }

  head(kind, name) {
    const made = element("h3");
    const field = element("input", "", { value: name });
    field.setAttribute("aria-label", `name of the ${kind} ${name}`);
    field.onchange = () => {
      const to = field.value.trim();
      if (!to) return refuse(field, `a ${kind} needs a name`);
      return sendTyped(field, (then) => this.each("rename", { kind, name, to }, then));
    };
    field.dataset.shown = name;
    const remove = element("button", "Remove", { type: "button", className: "small" });
    remove.onclick = () => this.each("remove", { kind, name });
    made.append(field, remove);
    return made;
  }

  seat({ name, there }) {
    const made = element("div", "", { className: "seat" });
    const head = this.head("seat", name);
    made.append(head);
    const picked = element("p", "", { className: "how" });
    const doubts = element("ul", "", { className: "doubts" });
    const fields = element("div", "", { className: "fields" });
    const notes = element("ul", "", { className: "notes" });
    made.append(picked, doubts, notes);
    const shows = [];
    const field = (words, figure, count, scale, step) => {
      const { made: numbers, show } = this.fields("seat", name, figure, count, scale, step);
      const how = element("span", "", { className: "how" });
      fields.append(element("span", words), numbers, how);
      shows.push((one) => {
        show(one[figure]);
        how.textContent = one.how[figure] ?? "";
        how.hidden = !how.textContent;
      });
    };
    if (there) {
      made.append(fields);
      const eye = element("button", "Eye of a seated person", { type: "button", className: "small" });
      eye.onclick = () => this.each("eye", { seat: name });
      head.append(eye);
      field("SRP x, y, z [mm]", "srp", 3, 0.001, "1");
      for (const [figure, words] of Object.entries(ANGLES)) field(`${words} [°]`, figure, 1, 1, "0.1");
      field("sinks into cushion [mm]", "cushion_depth", 1, 0.001, "1");
      field("sinks into back [mm]", "back_depth", 1, 0.001, "1");
      for (const [figure, words] of Object.entries(TRAVEL)) field(`${words} [mm]`, figure, 2, 0.001, "1");
      field("travel tilt, front up [°]", "tilt", 2, 1, "0.5");
      shows.push(this.moves(name, fields));
    }
    const show = (one) => {
      const faces = (count) => (count ? `${count} faces` : "not picked");
      const parts = there ? `${one.cushion} and ${one.back}` : "not yet a seat";
      const some = one.cushion_faces || one.back_faces;
      picked.textContent = some ? `${parts}; cushion: ${faces(one.cushion_faces)}, back: ${faces(one.back_faces)}` : parts;
      doubts.replaceChildren(...one.doubts.map((words) => element("li", words)));
      notes.replaceChildren(...one.notes.map((words) => element("li", words)));
      shows.forEach((each) => each(one));
    };
    return { made, show };
  }

  // The parts that go along with a seat; returns what shows them.
  moves(seat, fields) {
    const words = element("span");
    const set = element("button", "Take the chosen parts", { type: "button", className: "small" });
    set.onclick = () => this.each("carry", { seat, parts: this.chosen() });
    const cell = element("span");
    cell.append(words, " ", set);
    fields.append(element("span", "go along with it"), cell);
    return ({ moves }) => (words.textContent = moves.length ? moves.join(", ") : "no part");
  }

  control({ name }) {
    const made = element("div", "", { className: "thing" });
    const place = this.fields("control", name, "at", 3, 0.001, "1");
    const grip = this.choice(name, "grip", this.hello.grips, (value) => value);
    const zone = this.choice(name, "zone", this.hello.zones, Number);
    const how = element("span", "", { className: "how" });
    const own = this.own(name);
    made.append(this.head("control", name), place.made, grip.made, zone.made, how, own.made);
    const show = (one) => {
      place.show(one.at);
      grip.show(one.grip);
      zone.show(one.zone);
      how.textContent = [one.part && `part ${one.part}`, one.how].filter(Boolean).join("; ");
      own.show(one);
    };
    return { made, show };
  }

  // The other parts that are a control's own: taken along, or stated.
  own(control) {
    const made = element("span", "", { className: "how" });
    const ask = (words, parts) => {
      const button = element("button", words, { type: "button", className: "small" });
      button.onclick = () => this.each("own", { control, parts: parts() });
      return button;
    };
    const show = ({ part, pieces, stated }) => {
      const names = pieces.map((one) => one.part);
      const told = pieces.map((one) => (one.why ? `${one.part} (it touches ${one.beside}, and ${one.why})` : one.part)).join(", ");
      const words = stated ? `stated as its own: ${[part, ...names].join(", ")} ` : names.length ? `its own too: ${told} ` : "";
      const buttons = part ? [ask("Take the chosen parts", () => [...names, ...this.chosen()])] : [];
      if (names.length && !stated) buttons.push(ask("State these", () => names), ask(`${part} alone`, () => [part]));
      if (stated) buttons.push(ask("Look for its pieces", () => []));
      made.replaceChildren(words, ...buttons.flatMap((one) => [one, " "]));
    };
    return { made, show };
  }

  choice(name, figure, names, value) {
    const made = element("label", `${figure} `);
    const select = element("select");
    options(select, names.map(String));
    select.onchange = () => this.each("figure", { kind: "control", name, figure, value: value(select.value) });
    made.append(select);
    return { made, show: (now) => (select.value = String(now)) };
  }

  point({ name }) {
    const made = element("div", "", { className: "thing" });
    const place = this.fields("point", name, "at", 3, 0.001, "1");
    const how = element("span", "", { className: "how" });
    made.append(this.head("point", name), place.made, how);
    const show = (one) => {
      place.show(one.at);
      how.textContent = one.how;
    };
    return { made, show };
  }
}
