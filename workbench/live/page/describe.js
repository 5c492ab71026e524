// The page that makes an environment of a mesh by pointing. Names from files are only ever written as text.

import { pick } from "/view/pick.js";
import { vec } from "/view/camera.js";
import { ask, changes, connect } from "./connection.js";
import { at, bindHistory, commit, element, guardLeaving, heldFields, options, sendTyped } from "./elements.js";
import { Frame } from "./describe_frame.js";
import { Next } from "./describe_next.js";
import { Marks, everything } from "./describe_marks.js";
import { Parts } from "./describe_parts.js";
import { Things } from "./describe_things.js";
import { Picture } from "./picture.js";

const state = { hello: null, found: null, scene: "", axes: "", move: [0, 0, 0], walls: true, from: null };
const frame = new Frame(each);
const next = new Next(each, say);
const marks = new Marks();
const parts = new Parts();
const things = new Things(each, () => parts.names);
const picture = new Picture(document.querySelector("#picture .turn"), say, attach);

function each(verb, given, then) {
  ask(verb, given, true, then);
}

function take(found) {
  const { head } = found;
  const saved = () => (at("panels").scrollTop = 0); // where it goes on stands on top
  const moved = () => { // a study is open in the place of what was described
    state.moved = true;
    location.reload();
  };
  const what = { hello: takeHello, description: takeDescription, fault: takeFault, saved, moved };
  if (head.kind === "busy") say(head.what);
  if (what[head.kind]) what[head.kind](head, found.arrays);
}

function say(words, fault = false) {
  at("status").textContent = words;
  at("status").classList.toggle("fault", fault);
}

function takeHello(head) {
  state.hello = head;
  state.scene = state.axes = "";
  if (!at("control-grip").options.length) { // after a lost connection what was chosen stays
    options(at("control-grip"), head.grips, "grasp");
    options(at("control-zone"), head.zones.map(String), "1");
  }
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
  at("save").disabled = !state.hello.saves; // what is typed or computed just now may be saved too
  at("save-as").disabled = !state.hello.saves;
  at("sit").disabled = !head.seats.some((seat) => seat.there);
  at("sit").checked = head.sitting;
  if (head.words || head.answers || first) say([head.words, head.words.startsWith("saved ") && notUsed()].filter(Boolean).join("; "));
  at("choices").hidden = true;
  showFields();
  parts.show(head);
  next.show(head, state.hello.saves);
  at("notes").hidden = !head.warnings.length;
  at("warnings").replaceChildren(...head.warnings.map((one) => next.doubt(one)));
  marks.show(head, arrays);
  advance(head);
  if (head.scene !== state.scene) {
    state.scene = head.scene;
    picture.open();
  }
  showHint();
}

function showFields() {
  const { found, hello } = state;
  frame.show(found, hello);
  at("sizes").replaceChildren(...found.sizes.map((one) => next.doubt(one)));
  at("mode-meet").hidden = found.meshes.length < 2;
  options(at("add-files"), found.others, undefined, String);
  things.show(found, hello);
}

// What stands in fields and is not in what was saved.
function notUsed() {
  const words = heldFields().map((field) => `"${field.value}"${field.dataset.held === "refused" ? " was refused" : ""}`);
  return words.length ? `typed and not used: ${words.join(", ")}` : "";
}

/* ---- the picture ---- */

// A new picture: what is hidden stays so, and the camera stays where the mesh has.
function attach(panel) {
  const { viewer, scene } = panel;
  const box = everything(scene);
  viewer.camera.farthest = Math.max(60, 4 * Math.hypot(...vec.sub(box[1], box[0]))); // of a mesh in a wrong unit
  panel.stage.dataset.box = JSON.stringify(box);
  const axes = JSON.stringify(state.found.meshes.map(({ length, up, forward }) => [length, up, forward]));
  const look = (some) => {
    viewer.resize();
    viewer.camera.fit(some);
    viewer.draw();
  };
  viewer.fit = () => look(box);
  parts.bindLooks(panel, box, look);
  if (state.walls) panel.setWalls(); // walls are opaque at first; later pictures go on as they were
  state.walls = false;
  parts.attach(panel);
  marks.attach(panel);
  if (document.activeElement === document.body) viewer.canvas.focus({ preventScroll: true }); // the wheel zooms
  const { move } = state.found.meshes[0];
  if (axes !== state.axes) panel.view();
  else viewer.camera.at = vec.add(viewer.camera.at, vec.sub(move, state.move));
  Object.assign(state, { axes, move });
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
    "": "Drag turns, shift and drag moves, the wheel zooms once clicked. A click chooses; F and fit look at what is chosen, H hides what was clicked.",
    floor: "Click the floor: it becomes the height 0.",
    cushion: `Click the cushion of ${seat}; click again for more of it.`,
    back: `Click the back of ${seat}; click again for more of it.`,
    control: "Click where a hand or a foot takes hold.",
    point: "Click a point of the mesh. An eye point is had from a seated person too.",
    meet: state.from ? "Click where that point belongs, on another file." : "Click a point of the file that is to be moved.",
  };
  at("hint").textContent = words[mode()];
  for (const one of document.querySelectorAll(".with")) one.hidden = !one.dataset.for.split(" ").includes(mode());
}

// Where the picture was clicked, on a part: people and see-through parts are looked through.
function rayOf(hit) {
  const { panel } = picture;
  if (!hit || !panel) return {};
  const start = panel.viewer.camera.eye();
  const way = vec.unit(vec.sub(hit.point, start));
  const shown = { body: () => false, part: panel.viewer.shown.part };
  const met = pick(panel.scene, { from: start, way }, shown, panel.viewer.section);
  return met ? { part: panel.scene.place.parts[met.part].name, start, way, far: met.far } : {};
}

// The part that a hit is of.
function partOf(hit) {
  return hit?.kind === "part" ? picture.panel.scene.place.parts[hit.part].name : undefined;
}

document.addEventListener("chosen", (event) => {
  const ray = rayOf(event.detail);
  const asks = {
    "": () => parts.choose(partOf(event.detail) ?? ray.part),
    floor: () => each("floor", ray),
    cushion: () => each("face", { seat: at("seat-name").value, surface: "cushion", ...ray }),
    back: () => each("face", { seat: at("seat-name").value, surface: "back", ...ray }),
    control: () => {
      const name = at("control-name").value.trim();
      const given = { kind: "control", ...(name && { name }), grip: at("control-grip").value, zone: Number(at("control-zone").value), ...ray };
      at("control-name").dataset.shown = ""; // where it is refused the name stays
      sendTyped(at("control-name"), (then) => each("place", given, then));
    },
    point: () => {
      const name = at("point-name").value.trim();
      each("place", { kind: "point", ...(name && { name }), ...ray });
    },
    meet: () => {
      const { from } = state;
      if (!ray.part) return;
      state.from = from ? null : ray;
      if (from) each("meet", { ...from, ...Object.fromEntries(Object.entries(ray).map(([key, value]) => [`to_${key}`, value])) });
      showHint();
    },
  };
  asks[mode()]();
});

/* ---- commands ---- */

function takeFault(head) {
  say(head.words, true);
  if (state.found) restore();
  at("choices").hidden = head.ask !== "over";
  const over = element("button", "save over it", { onclick: () => ask("save", { ...state.asked, over: true }) });
  const again = element("button", "read the file again", { onclick: () => ask("reload") });
  at("choices").replaceChildren(over, again);
}

// What was refused is not so: lists and boxes show what holds. A text stays in its field.
function restore() {
  at("sit").checked = state.found.sitting;
  showFields();
  parts.mark();
}

function save(to) {
  commit();
  state.asked = to ? { to } : {};
  ask("save", state.asked);
}

document.querySelectorAll("input[name=mode]").forEach((input) => {
  input.onchange = () => {
    state.from = null;
    showHint();
  };
});
at("add").onsubmit = (event) => {
  event.preventDefault();
  const file = at("add-file").value.trim();
  at("add-file").dataset.shown = "";
  if (file) sendTyped(at("add-file"), (then) => each("add", { file }, then));
};
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
guardLeaving(() => {
  const { undo, saved, unsaved } = state.found ?? {};
  return !state.moved && ((unsaved && (undo || saved)) || changes() || heldFields().length > 0);
});

connect(take, say);
