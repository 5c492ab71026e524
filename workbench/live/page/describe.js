// The page that makes an environment of a mesh by pointing. Names from files are only ever written as text.

import { pick } from "/view/pick.js";
import { vec } from "/view/camera.js";
import { ask, connect } from "./connection.js";
import { at, bindHistory, element, options } from "./elements.js";
import { Frame } from "./describe_frame.js";
import { Marks } from "./describe_marks.js";
import { Parts } from "./describe_parts.js";
import { Things } from "./describe_things.js";
import { Picture } from "./picture.js";

const state = { hello: null, found: null, scene: "", axes: "", move: [0, 0, 0], walls: true };
const frame = new Frame(each);
const marks = new Marks();
const parts = new Parts();
const things = new Things(each, () => parts.names);
const picture = new Picture(document.querySelector("#picture .turn"), say, attach);

function each(verb, given) {
  ask(verb, given, true);
}

function take(found) {
  const { head } = found;
  const saved = () => (at("panels").scrollTop = 0); // where it goes on stands on top
  const what = { hello: takeHello, description: takeDescription, fault: takeFault, saved };
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
  frame.show(head, state.hello);
  parts.show(head);
  things.show(head, state.hello);
  showNext(head);
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

// Once all is saved: what is not finished, and the commands that lead on.
function showNext(head) {
  at("next").hidden = !head.next.length || head.unsaved;
  at("next-commands").textContent = head.next.join("\n");
  at("unfinished").replaceChildren(...head.unfinished.map((words) => element("li", words)));
}

/* ---- the picture ---- */

// A new picture: what is hidden stays so, and the camera stays where the mesh has.
function attach(panel) {
  const { viewer, scene } = panel;
  const box = everything(scene);
  viewer.camera.farthest = Math.max(60, 4 * Math.hypot(...vec.sub(box[1], box[0]))); // of a mesh in a wrong unit
  panel.stage.dataset.box = JSON.stringify(box);
  const axes = JSON.stringify(state.found.meshes.map(({ length, up, forward }) => [length, up, forward]));
  viewer.fit = () => {
    viewer.resize();
    viewer.camera.fit(box);
    viewer.draw();
  };
  if (state.walls) panel.toggleWalls(); // walls are opaque at first; later pictures go on as they were
  state.walls = false;
  parts.attach(panel);
  marks.attach(panel);
  if (document.activeElement === document.body) viewer.canvas.focus({ preventScroll: true }); // the wheel zooms
  const { move } = state.found.meshes[0];
  if (axes !== state.axes) panel.reset();
  else viewer.camera.at = vec.add(viewer.camera.at, vec.sub(move, state.move));
  Object.assign(state, { axes, move });
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
    "": "Drag turns, shift and drag moves, the wheel zooms once clicked. A click chooses; F looks at it, H hides what is in the way.",
    floor: "Click the floor: it becomes the height 0.",
    cushion: `Click the cushion of ${seat}; click again for more of it.`,
    back: `Click the back of ${seat}; click again for more of it.`,
    control: "Click where a hand or a foot takes hold.",
    point: "Click a point of the mesh. An eye point is had from a seated person too.",
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
  at("choices").replaceChildren(over, again);
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
