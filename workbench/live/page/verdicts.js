// Verdicts, and what is wrong with how people hold their controls and sit, with what may mend it.

import { plain } from "/view/pick.js";
import { at, element } from "./elements.js";
import { verdictRow } from "./rows.js";

const MENDS = { predict: "Predict the posture", free: "Predict all cases, let the seat go along" };

// What the verdicts come to, in words. one: the role that a population takes, of which one person is judged.
export function summary({ rows, warnings, waits, motions }, troubled, one) {
  const failed = rows.filter((row) => !row.passed).length;
  const looked = rows.filter((row) => row.asked).length;
  const known = [];
  if (failed) known.push(`${failed} failed`);
  else if (!waits && looked) known.push(troubled ? "all passed, but see below" : "all passed");
  else if (!waits) known.push("nothing was asked");
  if (one && looked) known[0] = `${known[0] ?? "being found"} for the one ${one} shown`;
  if (rows.length > looked && looked) known.push(`${rows.length - looked} found nothing to look at`);
  if (warnings.length) known.push(warnings.length > 1 ? `${warnings.length} warnings` : "1 warning");
  if (waits) known.push(motions ? `${motions[0]} of ${motions[1]} motions judged` : "motions are being judged");
  return known.length ? `(${known.join(", ")})` : "";
}

export class Verdicts {
  // visit, show: as of verdictRow; mend: is given a person of an answer who needs it.
  constructor(visit, show, mend) {
    Object.assign(this, { visit, show, mend });
    this.forget([]);
  }

  // Another study is open, with these people.
  forget(people) {
    const many = people.find((one) => one.many);
    this.one = many?.role ?? "";
    this.head = null;
    this.troubled = false;
    this.said = new Set();
    at("asks").hidden = !many;
    at("asks").textContent = many ? `Asked of the one ${many.role} in the picture; the shares above are of everybody.` : "";
  }

  // A state is answered: what is known of the one before is grey until it is judged.
  answered({ people, generation }) {
    at("verdicts").classList.toggle("waiting", generation !== this.head?.generation);
    this.generation = generation;
    for (const row of at("verdicts").children) this.mark(row);
    const wrong = people.filter(({ trouble }) => trouble.length);
    this.troubled = wrong.length > 0;
    this.said = new Set(wrong.flatMap((one) => one.trouble));
    at("trouble").hidden = !this.troubled;
    at("trouble").replaceChildren(...wrong.flatMap((one) => this.rows(one)));
    this.title();
  }

  // The sentences of a person, and a button where there is something that may mend it.
  rows(person) {
    const found = person.trouble.map((words) => element("li", words));
    if (person.offer) {
      const words = `${MENDS[person.offer]} (${person.role})`;
      const button = element("button", words, { type: "button", onclick: () => this.mend(person) });
      found.at(-1).append(" ", button);
    }
    return found;
  }

  judged(head) {
    const warnings = head.warnings.filter((words) => !this.said.has(plain(words))); // those are red already
    this.head = { ...head, warnings };
    at("verdicts").classList.remove("waiting");
    at("verdicts").replaceChildren(...head.rows.map((row) => verdictRow(row, this.visit, this.show)));
    at("warnings").hidden = !warnings.length;
    at("warnings").querySelector("ul").replaceChildren(...warnings.map((words) => element("li", words)));
    this.title();
  }

  // What is seen in a state, from where everybody is: this row alone is of that state until it is judged.
  sight({ generation, row }) {
    if (generation <= (this.head?.generation ?? -1)) return;
    const k = this.head?.rows.findIndex((one) => one.name === row.name && !one.time) ?? -1;
    if (k < 0) return;
    const made = verdictRow(row, this.visit, this.show);
    made.dataset.generation = generation;
    this.mark(made);
    at("verdicts").children[k].replaceWith(made);
  }

  // What is of the state that is shown is not grey.
  mark(row) {
    row.classList.toggle("now", Number(row.dataset.generation) === this.generation);
  }

  title() {
    if (!this.head) return;
    const words = summary(this.head, this.troubled, this.one);
    const before = words && this.head.generation !== this.generation;
    at("failed").textContent = before ? `${words.slice(0, -1)}, before this change)` : words;
  }
}
