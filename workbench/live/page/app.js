// The page of the bench: picture, verdicts, nearest pairs and native controls. Names from files are only ever
// written as text.

import { ask, connect, waits } from "./connection.js";
import { at, bindHistory, element, options } from "./elements.js";
import { Grips } from "./grips.js";
import { Looks } from "./looks.js";
import { People } from "./people.js";
import { Person } from "./person.js";
import { Picture } from "./picture.js";
import { ReachMaps } from "./reach_map.js";
import { nearRow, verdictRow } from "./rows.js";
import { Things } from "./things.js";

const state = { hello: null, answer: null, person: 0, held: null, letGo: false };
const picture = new Picture(document.querySelector("#picture .turn"), say, (panel) => {
  for (const one of [grips, looks]) one.attach(panel);
});
const things = new Things();
const grips = new Grips(state, things, choosePerson);
const people = new People();
const maps = new ReachMaps(at("people-maps"));
const person = new Person(state);
const looks = new Looks(state, picture, say);

function take(found) {
  const { head } = found;
  const what = { hello: takeHello, answer: takeAnswer, verdicts: takeVerdicts, fault: takeFault };
  if (what[head.kind]) what[head.kind](head);
  if (head.kind === "busy") say(head.what);
  if (head.kind === "people") people.show(head);
  if (head.kind === "reach_map") maps.show(head);
  looks.take(found);
  if (head.kind === "hello") {
    people.forget();
    maps.forget();
    looks.hello(head);
  }
  if (head.kind === "answer") {
    picture.show(found);
    looks.answered(head);
  }
}

/* ---- writing ---- */

function say(words, fault = false) {
  at("status").textContent = words;
  at("status").classList.toggle("fault", fault);
}

function takeHello(head) {
  state.hello = head;
  state.person = Math.max(0, Math.min(state.person, head.people.length - 1));
  document.title = head.title;
  at("title").textContent = head.title;
  options(at("case"), [...head.cases, ...head.motions]);
  options(at("person"), head.people.map((one) => one.role), head.people[state.person]?.role);
  at("person").parentElement.hidden = !head.people.length;
  options(at("limb-control"), ["", ...head.controls.map((one) => one.name)]);
  at("save").textContent = head.saves ? "Save" : "Save as…";
  if (head.notes.length) say(head.notes.join("; "));
  things.build(head);
  person.build();
  buildPosture();
}

function takeAnswer(head) {
  const first = state.answer === null;
  state.answer = head;
  at("undo").disabled = !head.undo;
  at("redo").disabled = !head.redo;
  at("save").disabled = !head.unsaved;
  at("case").value = looks.motion.name || head.case;
  at("took").textContent = head.ms < 2000 ? `answered in ${head.ms} ms` : `made ready in ${Math.round(head.ms / 1000)} s`;
  document.title = (head.unsaved ? "● " : "") + state.hello.title;
  if (head.words || head.answers || first) say(head.words);
  at("near").replaceChildren(...head.near.map((pair) => nearRow(pair, look, (one) => looks.measure.fill(one))));
  at("verdicts").classList.add("waiting");
  things.show(head);
  person.show();
  showPosture();
  grips.show();
}

const look = (point, words) => picture.lookAt(point, words);

function takeVerdicts(head) {
  const failed = head.rows.filter((row) => !row.passed).length;
  const known = head.waits ? "motions are being judged" : "all passed";
  at("failed").textContent = failed ? `(${failed} failed)` : `(${known})`;
  at("verdicts").classList.remove("waiting");
  at("verdicts").replaceChildren(...head.rows.map((row) => verdictRow(row, look, showCase)));
}

function takeFault(head) {
  say(head.words, true);
  const choices = {
    sharing: [["change all", { sharing: "all" }], ["this one only", { sharing: "one" }]],
    over: [["save over it", { over: true }], ["reload", null]],
  }[head.ask];
  at("choices").hidden = !choices;
  at("choices").replaceChildren(
    ...(choices ?? []).map(([words, given]) =>
      element("button", words, { onclick: () => (given ? save(given) : ask("reload")) }),
    ),
  );
}

/* ---- the posture of the person who is chosen ---- */

const sliders = [];

function slider(words, unit, send) {
  const row = element("label", "", { className: "slider" });
  const name = element("span", words);
  const input = element("input", "", { type: "range", step: "0.1" });
  input.setAttribute("aria-label", words);
  const value = element("output");
  input.oninput = () => {
    state.held = input;
    state.letGo = false;
    value.textContent = `${Number(input.value).toFixed(1)} ${unit}`;
    send(Number(input.value), false);
  };
  input.onchange = () => {
    state.letGo = true; // shown anew once the answer to this is there
    send(Number(input.value), true);
  };
  row.append(name, input, value);
  const show = (number, low, high, from = low, to = high) => {
    if (state.held === input) return;
    input.min = Math.min(from, number);
    input.max = Math.max(to, number);
    input.value = number;
    value.textContent = `${number.toFixed(1)} ${unit}`;
    const beyond = Math.max(number - high, low - number);
    row.classList.toggle("beyond", beyond > 0.05);
    const over = beyond > 0.05 ? `; ${beyond.toFixed(1)} beyond the stop` : "";
    input.setAttribute("aria-valuetext", `${number.toFixed(1)} ${unit}${over}`);
  };
  return { row, show };
}

function buildPosture() {
  const person = state.hello.people[state.person];
  sliders.length = 0;
  at("seat").replaceChildren();
  at("joints").replaceChildren();
  if (!person) return;
  if (person.seat) {
    ["forward", "up"].forEach((way) => {
      const made = slider(`seat ${way}`, "mm", (mm, done) => {
        const now = state.answer.people[state.person];
        ask("seat", { person: person.role, forward: now.forward, up: now.up, [way]: mm / 1000, done });
      });
      sliders.push((now) => {
        const [low, high] = person.seat[way].map((metres) => 1000 * metres);
        made.show(1000 * now[way], low, high);
      });
      at("seat").append(made.row);
    });
  }
  person.joints.forEach((joint, j) => {
    if (!joint.axes.some(Boolean)) return;
    const group = element("fieldset");
    group.append(element("legend", joint.name));
    joint.axes.forEach((motions, axis) => {
      if (!motions) return;
      const made = slider(`${motions[0]} / ${motions[1]}`, "°", (degrees, done) =>
        ask("joint", { person: person.role, joint: joint.joint, axis, degrees, done }),
      );
      sliders.push((now) => {
        const [up, down] = now.limits[j][axis];
        made.show(now.angles[j][axis], -down, up, Math.max(-180, -down - 10), Math.min(180, up + 10));
      });
      group.append(made.row);
    });
    at("joints").append(group);
  });
  if (state.answer) showPosture();
}

function showPosture() {
  const now = state.answer.people[state.person];
  if (!now) return;
  if (state.letGo && !waits()) state.held = null;
  sliders.forEach((show) => show(now));
}

/* ---- commands ---- */

function save(given = {}) {
  at("choices").hidden = true;
  const to = state.hello.saves ? null : prompt("Save under which name?", `my_${state.hello.file}`);
  if (!state.hello.saves && !to) return;
  ask("save", to ? { to, ...given } : given);
}

function showCase(name, time) {
  looks.show(name, time);
  grips.show();
}

at("case").onchange = () => showCase(at("case").value);
function choosePerson(number) {
  if (number === state.person) return;
  state.person = number;
  at("person").selectedIndex = number;
  person.build();
  buildPosture();
  grips.show();
}

at("person").onchange = () => choosePerson(at("person").selectedIndex);
bindHistory({ undo: () => ask("undo"), redo: () => ask("redo"), save: () => save() });
addEventListener("beforeunload", (event) => state.answer?.unsaved && event.preventDefault());

connect(take, say);
