// Unit and axes of the meshes: what is guessed, why, and what is asked about it.

import { at, element, options } from "./elements.js";

const UNSURE = "guessed, not sure";
const metres = (value) => `${value >= 100 ? value.toFixed(0) : value.toPrecision(3)} m`;

const button = (words, act) => element("button", words, { type: "button", className: "small", onclick: act });

export class Frame {
  // each: asks something of the bench.
  constructor(each) {
    Object.assign(this, { each, head: null });
    at("long").onchange = () => this.each("long", { row: 0, size: at("long").valueAsNumber });
  }

  show(head, hello) {
    this.head = head;
    const rows = head.meshes.map((mesh, row) => {
      const made = element("div", "", { className: "mesh" });
      if (head.meshes.length > 1) made.append(element("strong", mesh.file));
      const units = [...new Set([...hello.units, mesh.length])];
      const choices = { length: ["unit", units], up: ["up", hello.axes], forward: ["forward", hello.axes] };
      Object.entries(choices).forEach(([key, [words, names]], k) => {
        const select = element("select", "", { id: `mesh-${row}-${key}` });
        options(select, names, mesh[key]);
        select.onchange = () => this.each("mesh", { row, [key]: select.value });
        const label = element("label", `${words} `);
        label.append(select);
        made.append(label);
      });
      made.append(button("Turn round", () => this.turned(row, 2)), button("A quarter turn", () => this.turned(row, 1)));
      const how = reasons(mesh.how);
      if (how) made.append(element("span", how, { className: "how why" }));
      return made;
    });
    const focus = at("meshes").contains(document.activeElement) && document.activeElement.id;
    at("meshes").replaceChildren(...rows);
    if (focus) at(focus).focus();
    const [long, wide, high] = head.size;
    if (document.activeElement !== at("long")) at("long").value = Number(long.toPrecision(4));
    at("long").disabled = head.meshes.length > 1;
    at("extent-more").textContent = `, ${metres(wide)} wide, ${metres(high)} high. The person beside it: ${hello.person}.`;
    at("sizes").replaceChildren(...head.sizes.map((words) => element("li", words)));
    this.ask(head);
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
