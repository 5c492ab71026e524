// The report of the study, or of one of many people that is written beside it: made by the bench in a process of its
// own, with how far it is, and its first sentence.

import { ask } from "./connection.js";
import { at, element } from "./elements.js";

export class Reporting {
  // say: writes into the status line.
  constructor(say) {
    Object.assign(this, { say, ticking: 0, wanted: false });
    at("report-make").onclick = () => this.make({});
    at("report-ask").onclick = () => this.many();
    at("report-end").onclick = () => ask("report_end");
    at("report-many").oninput = () => this.label();
    this.label();
  }

  // A study is open: one of many people is asked for once.
  hello({ people, saves }) {
    at("report-one").hidden = !saves || people.some((one) => one.many);
  }

  label() {
    at("report-ask").textContent = `Ask ${at("report-many").value || "?"} people`;
  }

  many(how) {
    const people = at("report-many").valueAsNumber;
    if (!Number.isInteger(people) || people < 1) return this.say("how many people? A whole number from 1 on is needed", true);
    return this.make({ people, ...(how && { how }) });
  }

  make(given) {
    this.wanted = true;
    ask("report", given, true);
  }

  // How far it is, that it is there, or that it has ended.
  take({ study, words, ended, fault, ...found }) {
    if (words) return this.begin(`${study}: ${words}`);
    this.rest();
    if (fault) return this.say(`${study}: ${fault}`, true);
    if (ended) return this.say(`${study}: the run was ended; what it had finished of a population is kept for the next`);
    return this.show(study, found);
  }

  begin(words) {
    this.words = words;
    this.since ??= performance.now();
    for (const name of ["make", "ask"]) at(`report-${name}`).disabled = true;
    at("report-going").hidden = false;
    clearInterval(this.ticking);
    this.ticking = setInterval(() => this.write(), 1000);
    this.write();
  }

  write() {
    const seconds = Math.floor((performance.now() - this.since) / 1000);
    at("report-words").textContent = `${this.words} (${seconds} s so far)`;
  }

  rest() {
    clearInterval(this.ticking);
    this.since = undefined;
    at("report-going").hidden = true;
    for (const name of ["make", "ask"]) at(`report-${name}`).disabled = false;
  }

  show(study, { headline, lines, warnings, note, folder }) {
    at("report-found").hidden = false;
    at("report-headline").textContent = headline;
    const more = warnings ? `, with ${warnings} warning${warnings > 1 ? "s" : ""}` : "";
    at("report-where").textContent = `of ${study}, in ${folder}${more}`;
    at("report-lines").replaceChildren(...lines.map((line) => element("li", line, { className: line.startsWith("FAILED") ? "failed" : "" })));
    this.say(note || `the report of ${study} is there`);
    if (this.wanted) open(at("report-open").href, "workbench-report");
    this.wanted = false;
  }
}
