// Unit and axes of the meshes: what is guessed, why, and what is asked about it.

import { at, element, options, put, refuse, sendTyped } from "./elements.js";

const UNSURE = "guessed, not sure";
const metres = (value) => `${value >= 100 ? value.toFixed(0) : value.toPrecision(3)} m`;

const button = (words, act) => element("button", words, { type: "button", className: "small", onclick: act });

export class Frame {
  // each: asks something of the bench.
  constructor(each) {
    Object.assign(this, { each, head: null });
    at("long").onchange = () => {
      const size = at("long").valueAsNumber;
      if (!Number.isFinite(size)) return refuse(at("long"), "a number of metres is needed");
      return sendTyped(at("long"), (then) => this.each("long", { row: 0, size }, then));
    };
    this.rows = [];
  }

  show(head, hello) {
    Object.assign(this, { head, hello });
    const files = head.meshes.map(({ file }) => file).join("\n");
    if (files !== this.files) { // rows that stay keep what is being typed in them
      this.rows = head.meshes.map((mesh, row) => this.row(row, head.meshes.length));
      at("meshes").replaceChildren(...this.rows.map(({ made }) => made));
    }
    this.files = files;
    this.rows.forEach((row, k) => row.show(head.meshes[k]));
    const [long, wide, high] = head.size;
    put(at("long"), Number(long.toPrecision(4)));
    at("long").disabled = head.meshes.length > 1;
    at("extent-more").textContent = `, ${metres(wide)} wide, ${metres(high)} high. The person beside it: ${hello.person}.`;
    this.ask(head);
  }

  // The unit, the axes and, of several, the place of a file.
  row(row, count) {
    const { units, axes } = this.hello;
    const made = element("div", "", { className: "mesh" });
    const name = element("strong");
    if (count > 1) made.append(name);
    const lists = { length: ["unit", units], up: ["up", axes], forward: ["forward", axes] };
    const selects = Object.entries(lists).map(([key, [words, names]]) => {
      const select = element("select", "", { id: `mesh-${row}-${key}` });
      select.onchange = () => this.each("mesh", { row, [key]: select.value });
      const label = element("label", `${words} `);
      label.append(select);
      made.append(label);
      return (mesh) => options(select, [...new Set([...names, mesh[key]])], mesh[key]);
    });
    made.append(button("Turn round", () => this.turned(row, 2)), button("A quarter turn", () => this.turned(row, 1)));
    if (count > 1) selects.push(this.place(row, made));
    if (row && row === count - 1) made.append(button("Take it away", () => this.each("take", { row })));
    const how = element("span", "", { className: "how why" });
    made.append(how);
    const show = (mesh) => {
      name.textContent = mesh.file;
      for (const one of selects) one(mesh);
      how.textContent = reasons(mesh.how);
    };
    return { made, show };
  }

  // Number fields [mm] of where a file is; returns what shows them.
  place(row, made) {
    const label = element("span", "moved by x, y, z [mm] ");
    const fields = [0, 1, 2].map((k) => {
      const field = element("input", "", { type: "number", step: "1" });
      field.setAttribute("aria-label", `file ${row + 1}: moved by, ${"xyz"[k]}`);
      field.onchange = () => {
        const to = fields.map((one) => Number((one.valueAsNumber / 1000).toPrecision(12)));
        if (!to.every(Number.isFinite)) return refuse(field, "a number of millimetres is needed");
        return sendTyped(field, (then) => this.each("move", { row, to }, then));
      };
      label.append(field, " ");
      return field;
    });
    made.append(label);
    return ({ move }) => fields.forEach((field, k) => put(field, Number((1000 * move[k]).toFixed(1))));
  }

  // What is guessed and not sure is asked about in plain words; all guesses can be agreed to.
  ask(head) {
    const unsure = (k) => head.meshes.some((mesh) => mesh.how[k].startsWith(UNSURE));
    const guessed = head.meshes.some((mesh) => mesh.how.some((words) => words.startsWith("guessed")));
    const asks = [
      unsure(0) && "Is the unit right? Compare with the person, or type how long it is.",
      unsure(1) && "Which way is up? The person stands upright.",
      unsure(2) && "Which way is the front? The arrow says.",
    ].filter(Boolean);
    at("ask").hidden = !guessed;
    at("ask").classList.toggle("plain", !asks.length);
    const about = asks.length ? asks.join(" ") : "Unit and axes are guessed in part: are they right?";
    at("ask").replaceChildren(`${about} `, button("They are right", () => this.each("agree")));
  }

  // Another front, so many quarter turns to the left of what is the front now.
  turned(row, quarters) {
    const { up, forward } = this.head.meshes[row];
    const plain = (axis) => axis.replace("-", "");
    const opposite = (axis) => (axis.startsWith("-") ? plain(axis) : `-${axis}`);
    const free = ["x", "y", "z"].find((axis) => axis !== plain(up) && axis !== plain(forward));
    const after = quarters === 2 ? opposite(forward) : free;
    this.each("mesh", { row, forward: after });
  }
}

// Why a unit and axes are guessed as they are: each reason once.
function reasons(how) {
  const names = ["unit", "up", "forward"];
  const guessed = how.map((words, k) => words.startsWith("guessed") && `${names[k]} ${words.replace(UNSURE, "guessed")}`);
  return guessed.filter(Boolean).join("; ");
}
