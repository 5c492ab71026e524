// The page that makes an environment of a mesh by pointing. Names from files are only ever written as text.

import { pick } from "/view/pick.js";
import { vec } from "/view/camera.js";
import { ask, connect } from "./connection.js";
import { at, bindHistory, element, options } from "./elements.js";
import { Marks } from "./describe_marks.js";
import { Parts } from "./describe_parts.js";
import { Things } from "./describe_things.js";
import { Picture } from "./picture.js";

const state = { hello: null, found: null, scene: "", frame: "", walls: true };
const marks = new Marks();
const parts = new Parts();
const things = new Things(each);
const picture = new Picture(document.querySelector("#picture .turn"), say, attach);

function each(verb, given) {
  ask(verb, given, true);
}

function take(found) {
  const { head } = found;
  const what = { hello: takeHello, description: takeDescription, fault: takeFault };
  if (head.kind === "busy") say(head.what);
  if (what[head.kind]) what[head.kind](head, found.arrays);
}

function say(words, fault = false) {
  at("status").textContent = words;
  at("status").classList.toggle("fault", fault);
}

function takeHello(head) {
  state.hello = head;
  state.scene = state.frame = "";
  options(at("control-grip"), head.grips, "grasp");
  options(at("control-zone"), head.zones.map(String), "1");
  at("choices").hidden = true;
}

function takeDescription(head, arrays) {
  const first = !state.found;
  state.found = head;
  document.title = (head.unsaved ? "● " : "") + head.name;
  at("title").textContent = head.name;
  at("file").textContent = head.saved ? `in ${head.file}` : `not saved yet; ${head.file} in ${state.hello.folder}`;
  at("undo").disabled = !head.undo;
  at("redo").disabled = !head.redo;
  at("save").disabled = !state.hello.saves || !head.unsaved;
  at("save-as").disabled = !state.hello.saves;
  at("sit").disabled = !head.seats.some((seat) => seat.there);
  at("sit").checked = head.sitting;
  if (head.words || head.answers || first) say(head.words);
  at("choices").hidden = true;
  showMeshes(head);
  parts.show(head);
  things.show(head, state.hello);
  at("notes").hidden = !head.warnings.length;
  at("warnings").replaceChildren(...head.warnings.map((words) => element("li", words)));
  marks.show(head, arrays);
  advance(head);
  if (head.scene !== state.scene) {
    state.scene = head.scene;
    picture.open();
  }
  showHint();
}

/* ---- unit and axes ---- */

function showMeshes(head) {
  const rows = head.meshes.map((mesh, row) => {
    const made = element("div", "", { className: "mesh" });
    if (head.meshes.length > 1) made.append(element("strong", mesh.file));
    const units = [...new Set([...state.hello.units, mesh.length])];
    const choices = { length: ["unit", units], up: ["up", state.hello.axes], forward: ["forward", state.hello.axes] };
    Object.entries(choices).forEach(([key, [words, names]], k) => {
      const select = element("select", "", { id: `mesh-${row}-${key}` });
      options(select, names, mesh[key]);
      select.onchange = () => each("mesh", { row, [key]: select.value });
      const label = element("label", `${words} `);
      label.append(select);
      if (mesh.how[k].startsWith("guessed")) label.append(element("span", " guessed", { className: "how" }));
      made.append(label);
    });
    return made;
  });
  if (!at("meshes").contains(document.activeElement)) at("meshes").replaceChildren(...rows);
  else head.meshes.forEach((mesh, row) => ["length", "up", "forward"].forEach((key) => (at(`mesh-${row}-${key}`).value = mesh[key])));
  const [long, wide, high] = head.size.map(metres);
  at("size").textContent = `${long} long, ${wide} wide, ${high} high. The person beside it: ${state.hello.person}.`;
  at("sizes").replaceChildren(...head.sizes.map((words) => element("li", words)));
}

const metres = (value) => `${value >= 100 ? value.toFixed(0) : value.toPrecision(3)} m`;

/* ---- the picture ---- */

// A new picture: what is hidden stays so, and the camera stays where the mesh has.
function attach(panel) {
  const { viewer, scene } = panel;
  const box = everything(scene);
  viewer.camera.farthest = Math.max(60, 4 * Math.hypot(...vec.sub(box[1], box[0]))); // of a mesh in a wrong unit
  panel.stage.dataset.box = JSON.stringify(box);
  const frame = JSON.stringify(state.found.meshes.map(({ length, up, forward }) => [length, up, forward]));
  viewer.fit = () => {
    viewer.resize();
    viewer.camera.fit(box);
    viewer.draw();
  };
  if (state.walls) panel.toggleWalls();
  parts.attach(panel);
  marks.attach(panel);
  if (frame !== state.frame) panel.reset();
  state.frame = frame;
}

function everything(scene) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const points of [scene.place.vertices, ...scene.bodies.map((body) => body.centres)]) {
    for (let i = 0; i < points.length; i++) {
      if (points[i] < low[i % 3]) low[i % 3] = points[i];
      if (points[i] > high[i % 3]) high[i % 3] = points[i];
    }
  }
  return [low, high];
}

const mode = () => document.querySelector("input[name=mode]:checked").value;

function choose(name) {
  document.querySelector(`input[name=mode][value="${name}"]`).checked = true;
  showHint();
}

// Once a cushion is there its back is next.
function advance(head) {
  const seat = head.seats.find((one) => one.name === at("seat-name").value.trim());
  if (mode() === "cushion" && seat?.cushion_faces && !seat.back_faces) choose("back");
}

function showHint() {
  const seat = at("seat-name").value.trim() || "a seat";
  const words = {
    "": "Drag turns, a click names and chooses; hide what is in the way in the list of parts.",
    floor: "Click the floor: it becomes the height 0.",
    cushion: `Click the cushion of ${seat}; click again for more of it.`,
    back: `Click the back of ${seat}; click again for more of it.`,
    control: "Click where a hand or a foot takes hold.",
    point: "Click a point of the mesh. An eye point is had from a seated person too.",
  };
  at("hint").textContent = words[mode()];
  for (const one of document.querySelectorAll(".with")) one.hidden = !one.dataset.for.split(" ").includes(mode());
}

// Where the picture was clicked, on a part: people are looked through.
function rayOf(hit) {
  const { panel } = picture;
  if (!hit || !panel) return {};
  const start = panel.viewer.camera.eye();
  const way = vec.unit(vec.sub(hit.point, start));
  const shown = { body: () => false, part: panel.viewer.shown.part };
  const met = pick(panel.scene, { from: start, way }, shown, panel.viewer.section);
  return met ? { part: panel.scene.place.parts[met.part].name, start, way, far: met.far } : {};
}

document.addEventListener("chosen", (event) => {
  const ray = rayOf(event.detail);
  const asks = {
    "": () => parts.choose(ray.part),
    floor: () => each("floor", ray),
    cushion: () => each("face", { seat: at("seat-name").value, surface: "cushion", ...ray }),
    back: () => each("face", { seat: at("seat-name").value, surface: "back", ...ray }),
    control: () => {
      const name = at("control-name").value.trim();
      each("place", { kind: "control", ...(name && { name }), grip: at("control-grip").value, zone: Number(at("control-zone").value), ...ray });
      at("control-name").value = "";
    },
    point: () => {
      const name = at("point-name").value.trim();
      each("place", { kind: "point", ...(name && { name }), ...ray });
    },
  };
  asks[mode()]();
});

/* ---- commands ---- */

function takeFault(head) {
  say(head.words, true);
  at("choices").hidden = head.ask !== "over";
  const over = element("button", "save over it", { onclick: () => ask("save", { ...state.asked, over: true }) });
  const again = element("button", "read the file again", { onclick: () => ask("reload") });
  at("choices").replaceChildren(over, ...(state.found.saved ? [again] : []));
}

function save(to) {
  state.asked = to ? { to } : {};
  ask("save", state.asked);
}

document.querySelectorAll("input[name=mode]").forEach((input) => (input.onchange = showHint));
at("seat-name").oninput = showHint;
at("anew").onclick = () => each("anew", { seat: at("seat-name").value, surface: mode() });
at("sit").onchange = () => {
  if (at("sit").checked) say("seating a person; the first time this takes a while");
  each("sit", { on: at("sit").checked });
};
bindHistory({ undo: () => each("undo"), redo: () => each("redo"), save: () => save() });
at("save-as").onclick = () => {
  const to = prompt("Save under which name, in the same folder?", state.found.file);
  if (to) save(to);
};
addEventListener("beforeunload", (event) => state.found?.undo && state.found.unsaved && event.preventDefault());

connect(take, say);
