// The page of the bench: picture, verdicts, nearest pairs and native controls. Names from files are only ever
// written as text.

import { ask, askedAfter, changes, connect } from "./connection.js";
import { at, bindHistory, element, guardLeaving, options } from "./elements.js";
import { Grips } from "./grips.js";
import { Keys, commandsOf } from "./keys.js";
import { Looks } from "./looks.js";
import { People } from "./people.js";
import { Person } from "./person.js";
import { Picture } from "./picture.js";
import { Progress, Waiting } from "./progress.js";
import { ReachMaps } from "./reach_map.js";
import { Reporting } from "./reporting.js";
import { nearRow } from "./rows.js";
import { Sliders } from "./sliders.js";
import { Things } from "./things.js";
import { Verdicts } from "./verdicts.js";

const state = { hello: null, answer: null, person: 0 };
const progress = new Progress();
const waiting = new Waiting();
const picture = new Picture(document.querySelector("#picture .turn"), say, (panel) => {
  for (const one of [grips, looks]) one.attach(panel);
  progress.done(progress.steps.length - 1);
});
const sliders = new Sliders(state);
const things = new Things(say);
const grips = new Grips(state, things, choosePerson);
const people = new People();
const maps = new ReachMaps(at("people-maps"));
const person = new Person(state);
const looks = new Looks(state, picture, say);
const reporting = new Reporting(say);
const verdicts = new Verdicts(visit, showCase, (one) => person.mend(one));

function take(found) {
  const { head } = found;
  const what = { hello: takeHello, answer: takeAnswer, verdicts: (one) => verdicts.judged(one), sight: (one) => verdicts.sight(one), fault: takeFault };
  if (what[head.kind]) what[head.kind](head);
  if (head.kind === "busy") busy(head.what);
  if (head.kind === "people") people.show(head);
  if (head.kind === "reach_map") maps.show(head);
  if (head.kind === "report") reporting.take(head);
  looks.take(found);
  if (head.kind === "near") showNear(head.rows);
  if (head.kind === "motion") progress.done(1);
  if (head.kind === "hello") {
    people.forget(head.people);
    maps.forget();
    looks.hello(head);
    progress.begin(stepsOf(head));
  }
  if (head.kind === "answer") {
    picture.show(found);
    looks.answered(found);
  }
}

/* ---- writing ---- */

const SPEAK = 1000; // milliseconds between two messages that are read aloud
let spoken = 0;
let refused = 0; // [ms] when the page itself refused what is in the status line, 0 where it did not

function say(words, fault = false) {
  waiting.end();
  refused = fault ? performance.now() : 0;
  at("status").textContent = words;
  at("status").classList.toggle("fault", fault);
  spoken ||= setTimeout(() => {
    spoken = 0;
    at("spoken").textContent = at("status").textContent;
  }, SPEAK);
}

function busy(words) {
  say(words);
  waiting.begin(words);
}

// What is done until the picture is there.
function stepsOf({ cases, triangles }) {
  const motion = cases.length ? [] : ["the motion is being read"];
  const picture = `the picture of ${triangles.toLocaleString("en")} triangles is being made`;
  return ["the first answer is being made", ...motion, picture];
}

function takeHello(head) {
  if (head.cases.length) looks.motion.wantsPlay = false;
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
  verdicts.forget(head.people);
  reporting.hello(head);
  things.build(head);
  person.build();
  sliders.build();
}

function takeAnswer(head) {
  const first = state.answer === null;
  state.answer = head;
  at("undo").disabled = !head.undo;
  at("redo").disabled = !head.redo;
  at("save").disabled = false; // what is still computed is saved too, once it is there
  at("case").value = looks.motion.name || head.case;
  at("took").textContent = head.ms < 2000 ? `answered in ${head.ms} ms` : `made ready in ${Math.round(head.ms / 1000)} s`;
  document.title = (head.unsaved ? "● " : "") + state.hello.title;
  // A late answer takes no refusal away: that belongs to what was pressed since.
  if (head.words || first || (head.answers && askedAfter(refused))) say(head.words);
  progress.done(0);
  if (!looks.motion.there) showNear(head.near);
  verdicts.answered(head);
  people.answered(head);
  things.show(head);
  person.show();
  sliders.show();
  grips.show();
}

function showNear(rows) {
  at("near").replaceChildren(...rows.map((pair) => nearRow(pair, look, (one) => looks.measure.fill(one))));
}

const look = (point, words) => picture.lookAt(point, words);

// Look at the place of a verdict, in its case and with its person's sliders.
function visit(point, words, verdict) {
  const person = state.hello.people.findIndex((one) => one.role === verdict.person);
  if (person >= 0) choosePerson(person);
  if (verdict.case && verdict.case !== at("case").value && verdict.time === null) showCase(verdict.case);
  look(point, words);
}

function takeFault(head) {
  if (state.answer && head.where) restore();
  say(head.words, true);
  refused = 0; // what waits behind it may be answered
  const choices = {
    sharing: [["change all", { sharing: "all" }], ["this one only", { sharing: "one" }]],
    over: [["save over it", { over: true }], ["reload", null]],
    people: [["run it as it is", "as it is"], ["write another one", "anew"]],
  }[head.ask];
  at("choices").hidden = !choices;
  at("choices").replaceChildren(
    ...(choices ?? []).map(([words, given]) =>
      element("button", words, { onclick: () => choose(head.ask, given) }),
    ),
  );
}

function choose(asked, given) {
  at("choices").hidden = true;
  if (asked === "people") reporting.many(given);
  else if (given) save(given);
  else ask("reload");
}

// What was asked is refused: every field shows what holds.
function restore() {
  things.restore();
  person.restore();
  sliders.restore();
  grips.show();
  grips.showTip();
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
  sliders.build();
  grips.show();
}

at("person").onchange = () => choosePerson(at("person").selectedIndex);
bindHistory({ undo: () => ask("undo", {}, true), redo: () => ask("redo", {}, true), save: () => save() });
new Keys({
  commands: () => commandsOf({ hello: state.hello, panel: picture.panel, show: showCase, choosePerson }),
  picture: (event) => picture.panel?.touch.key(event),
  other: (step) => {
    const next = at("case").options[at("case").selectedIndex + step];
    if (next) showCase(next.value);
  },
  others: { g: () => looks.ghost.toggle(), p: () => looks.copying.copy(), m: () => looks.filming.toggle(), r: () => at("report-make").click() },
  play: () => looks.motion.play(Boolean(state.hello)),
});
guardLeaving(() => state.answer?.unsaved || changes());

connect(take, say);
