// The parts: which are shown, which are chosen, and what becomes of the chosen ones.

import { ask } from "./connection.js";
import { vec } from "/view/camera.js";
import { clearest } from "/view/pick.js";
import { at, element, put, sendTyped } from "./elements.js";

const FRAME = [226, 120, 0];
const MOST_FRAMES = 60;

const boxOf = ({ at: middle, size }) => [vec.sub(middle, vec.mul(size, 0.5)), vec.add(middle, vec.mul(size, 0.5))];

const middleOf = ([low, high]) => vec.mul(vec.add(low, high), 0.5);

// The twelve edges of a box.
function edgesOf(box) {
  const corner = (k) => [0, 1, 2].map((i) => box[(k >> i) & 1][i]);
  const ends = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((k) => [1, 2, 4].filter((bit) => !(k & bit)).map((bit) => [k, k | bit]));
  return ends.map(([from, to]) => ({ from: corner(from), to: corner(to), colour: FRAME }));
}

export class Parts {
  constructor() {
    Object.assign(this, { panel: null, head: null, hidden: new Set(), chosen: new Set() });
    at("part-find").oninput = () => this.find();
    at("part-show").onclick = () => this.showOnly(null);
    at("part-none").onclick = () => this.showOnly(new Set());
    at("part-alone").onclick = () => this.showOnly(this.chosen);
    at("part-look").onclick = () => this.panel?.focus();
    at("part-form").onsubmit = (event) => event.preventDefault();
    at("part-edit").onsubmit = (event) => {
      event.preventDefault();
      const to = at("part-name").value.trim();
      if (to) sendTyped(at("part-name"), (then) => ask("join", { parts: this.names, to }, true, then));
    };
    at("part-leave").onclick = () => this.ask("leave", { parts: this.names });
    at("part-split").onclick = () => this.names.forEach((part) => this.ask("split", { part }));
    at("part-glass").onclick = () => this.rule("see_through", !this.all((part) => part.see_through));
    at("part-hidden").onclick = () => this.rule("hidden", !this.all((part) => part.hidden));
    at("part-solid").onchange = () => {
      const { value } = at("part-solid");
      this.rule("solid", value === "auto" ? value : value === "true");
    };
  }

  ask(verb, given) {
    ask(verb, given, true);
  }

  get names() {
    return this.head.parts.map((part) => part.name).filter((name) => this.chosen.has(name));
  }

  // The parts that are in the picture.
  get shown() {
    return this.head.parts.filter((part) => !part.hidden && !this.hidden.has(part.name)).map((part) => part.name);
  }

  // The box of the chosen parts, or of those that are shown where some are not; null for all.
  box() {
    const names = this.chosen.size ? this.chosen : new Set(this.shown);
    if (!names.size || (names.size === this.head.parts.length && !this.chosen.size)) return null;
    return this.boxAbout(names);
  }

  boxAbout(names) {
    const boxes = this.head.parts.filter((part) => names.has(part.name)).map(boxOf);
    const [low, high] = [Math.min, Math.max].map((least, k) => [0, 1, 2].map((i) => least(...boxes.map((one) => one[k][i]))));
    return [low, high];
  }

  // fit and F of a picture: what is chosen, alone; else what is shown of it. look: looks at a box.
  bindLooks(panel, everything, look) {
    // Where the camera looks at all, the middle is that of the mesh: the man beside it counts for nothing.
    panel.lookedAt = () => {
      const { at } = panel.viewer.camera;
      const all = Math.hypot(...vec.sub(at, middleOf(everything))) < 1e-6;
      return all && this.shown.length ? middleOf(this.boxAbout(new Set(this.shown))) : at;
    };
    panel.fit = () => {
      panel.leave();
      look(this.box() ?? everything);
    };
    panel.focus = () => {
      if (!this.chosen.size) return panel.chosen && panel.lookAt(panel.chosen.point);
      const { scene, viewer } = panel;
      const box = this.box();
      const there = new Set(this.shown);
      const shown = { body: () => false, part: (k) => there.has(scene.place.parts[k].name) };
      panel.leave();
      const { azimuth, height } = clearest(scene, viewer.camera, vec.mul(vec.add(...box), 0.5), shown, viewer.section);
      viewer.camera.look(azimuth, height);
      return look(box);
    };
  }

  all(what) {
    const some = this.head.parts.filter((part) => this.chosen.has(part.name));
    return some.length > 0 && some.every(what);
  }

  rule(rule, value) {
    for (const part of this.names) this.ask("rule", { part, rule, value });
  }

  attach(panel) {
    this.panel = panel;
    panel.viewer.canvas.addEventListener("keyup", () => this.follow());
    this.hide();
    if (this.head) this.outline();
  }

  // The boxes of the list follow what the keys of the picture have hidden.
  follow() {
    this.takeHidden();
    for (const row of at("parts").rows) row.querySelector("input").checked = !this.hidden.has(row.dataset.name);
  }

  // Choose the part of a name alone; none for "".
  choose(name) {
    this.chosen = new Set(name ? [name] : []);
    this.mark();
    const row = [...at("parts").rows].find((one) => one.dataset.name === name);
    row?.scrollIntoView({ block: "nearest" });
  }

  show(head) {
    this.takeHidden();
    const names = head.parts.map((part) => part.name);
    const made = names.filter((name) => !(this.head ?? head).parts.some((part) => part.name === name));
    // What the chosen parts were renamed to, or joined to, is chosen in their place.
    if (this.chosen.size && made.length === 1 && !names.some((name) => this.chosen.has(name))) this.chosen.add(made[0]);
    this.head = head;
    for (const kept of [this.hidden, this.chosen]) {
      for (const name of kept) if (!names.includes(name)) kept.delete(name);
    }
    at("parts-count").textContent = `(${names.length})`;
    const many = head.of.toLocaleString("en");
    const few = head.drawn.toLocaleString("en");
    at("drawn").textContent = head.drawn < head.of
      ? `The picture draws ${few} of ${many} triangles; what is picked is measured on all of them.` : `${many} triangles`;
    at("parts").replaceChildren(...head.parts.map((part) => this.row(part)));
    at("left").replaceChildren(...(head.left.length ? ["left out: "] : []), ...head.left.map((one) => this.left(one)));
    this.find();
    this.mark();
    this.hide();
  }

  // What the keys of the picture have hidden or shown since.
  takeHidden() {
    if (!this.panel || !this.head) return;
    const out = this.head.parts.filter((part) => part.hidden).map((part) => part.name);
    const names = this.panel.scene.place.parts.map((part) => part.name);
    const { hiddenParts } = this.panel.viewer;
    this.hidden = new Set(names.filter((name, k) => hiddenParts.has(k) && !out.includes(name)));
  }

  row(part) {
    const { name, size } = part;
    const made = element("tr");
    made.dataset.name = name;
    const box = (label, checked, act) => {
      const input = element("input", "", { type: "checkbox", checked });
      input.setAttribute("aria-label", `${label} ${name}`);
      input.onchange = () => act(input.checked);
      const cell = element("td");
      cell.append(input);
      return cell;
    };
    const put = (set, then) => (on) => {
      if (on) set.add(name);
      else set.delete(name);
      then();
    };
    const words = [part.hidden && "hidden", part.see_through && "see-through", part.solid !== "auto" && (part.solid ? "solid" : "not solid")];
    const cell = element("td", name, { className: "name" });
    const more = words.filter(Boolean).join(", ");
    if (more) cell.append(element("span", ` ${more}`, { className: "more" }));
    const millimetres = size.map((value) => (1000 * value).toFixed(0)).join(" × ");
    made.append(
      box("show", !this.hidden.has(name), (on) => this.toggle(name, on)),
      box("choose", this.chosen.has(name), put(this.chosen, () => this.mark())),
      cell,
      element("td", millimetres, { className: "number" }),
    );
    return made;
  }

  toggle(name, on) {
    if (on) this.hidden.delete(name);
    else this.hidden.add(name);
    this.hide();
  }

  left({ row, name }) {
    const made = element("button", `${name}: put back`, { type: "button", className: "small" });
    made.onclick = () => this.ask("back", { row, name });
    return made;
  }

  find() {
    const wanted = at("part-find").value.trim().toLowerCase();
    for (const row of at("parts").rows) row.hidden = !row.dataset.name.toLowerCase().includes(wanted);
  }

  mark() {
    for (const row of at("parts").rows) {
      const chosen = this.chosen.has(row.dataset.name);
      row.classList.toggle("chosen", chosen);
      row.querySelectorAll("input")[1].checked = chosen;
    }
    const names = this.names;
    put(at("part-name"), names[0] ?? "");
    this.outline();
    for (const id of ["part-leave", "part-split", "part-glass", "part-hidden", "part-solid", "part-alone", "part-look"]) at(id).disabled = !names.length;
    at("part-edit").querySelector("[type=submit]").disabled = !names.length;
    const solid = [...new Set(this.head.parts.filter((part) => this.chosen.has(part.name)).map((part) => String(part.solid)))];
    at("part-solid").value = solid.length === 1 ? solid[0] : "auto";
  }

  // Frames around what is chosen, so that it is seen where it is small or behind others.
  outline() {
    const some = this.head.parts.filter((part) => this.chosen.has(part.name)).slice(0, MOST_FRAMES);
    this.panel?.viewer.setMarks(some.flatMap((part) => edgesOf(boxOf(part))), "chosen");
  }

  showOnly(names) {
    const gone = names ? this.head.parts.filter((part) => !names.has(part.name)) : [];
    this.hidden = new Set(gone.map((part) => part.name));
    this.hide();
    this.follow();
  }

  // What is hidden here, and what the environment says is hidden, is not in the picture.
  hide() {
    if (!this.panel || !this.head) return;
    const out = new Set(this.head.parts.filter((part) => part.hidden).map((part) => part.name));
    const { hiddenParts } = this.panel.viewer;
    hiddenParts.clear();
    this.panel.scene.place.parts.forEach((part, k) => {
      if (this.hidden.has(part.name) || out.has(part.name)) hiddenParts.add(k);
    });
    this.panel.viewer.partsChanged();
  }
}
