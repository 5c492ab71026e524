// The keys of the whole page, the list of commands (Ctrl K) and the list of keys (?).

import { at, element } from "./elements.js";

const KEYS = [
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["Ctrl S", "save"],
  ["Ctrl K", "list of commands"],
  ["[ and ]", "the case before, the next case"],
  ["space", "play or pause a motion"],
  ["Esc", "drop what is being dragged and put it back; in the picture: show all again"],
  ["arrows", "turn the picture, or move a slider by 0.1; with shift ten times as far"],
  ["+ and -", "zoom"],
  ["1 to 6, 0", "views; all in the picture"],
  ["F, H, I", "look at what was clicked, hide it, show it alone"],
  ["X, C", "see-through walls, section"],
  ["G", "the saved state as a ghost beside what is"],
  ["P", "copy the picture"],
  ["M", "film the motion, or once round; end the film"],
  ["R", "make the report"],
  ["?", "this list"],
];
const TYPED = /^(number|text|search)$/;
const SLIDER = /^(Arrow|Page|Home|End| $)/;

// Whether a key belongs to the element that has the focus.
export function isOfElement(key, { name, type = "" }) {
  if (name === "TEXTAREA" || name === "SELECT" || (name === "INPUT" && TYPED.test(type))) return true;
  if (name === "INPUT" || name === "SUMMARY") return SLIDER.test(key);
  return name === "BUTTON" && (key === " " || key === "Enter");
}

export class Keys {
  // commands: gives the rows { words, keys, act } that there are now; picture: is given the keys that
  // nothing else takes; other: goes to the case before or the next one; play: plays a motion; others: what more keys do.
  constructor({ commands, picture, other, play, others }) {
    Object.assign(this, { commands, picture });
    const acts = { "[": () => other(-1), "]": () => other(1), " ": play, ...others, "?": () => this.help() };
    addEventListener("keydown", (event) => this.take(event, acts));
    document.addEventListener("case", (event) => other(event.detail));
    at("command-find").oninput = () => this.list();
    at("commands").onkeydown = (event) => this.walk(event);
    at("help").onclick = () => this.help();
    at("keys-rows").replaceChildren(
      ...KEYS.map(([keys, words]) => {
        const row = element("tr");
        row.append(element("th", keys, { scope: "row" }), element("td", words));
        return row;
      }),
    );
  }

  take(event, acts) {
    const { target } = event;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "k") {
      event.preventDefault();
      return this.open();
    }
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector("dialog[open]")) return;
    // What was hidden a moment ago keeps the focus until the page is painted.
    const shown = target.getClientRects?.().length;
    if (shown && isOfElement(event.key, { name: target.tagName ?? "", type: target.type })) return;
    const act = acts[event.key.toLowerCase()];
    if (act) {
      event.preventDefault();
      act();
    } else if (event.key !== "Escape") this.picture(event);
  }

  help() {
    at("keys").showModal();
  }

  open() {
    this.rows = this.commands();
    at("command-find").value = "";
    this.list();
    if (!at("commands").open) at("commands").showModal();
    at("command-find").focus();
  }

  // The commands that have all that was typed in them.
  list() {
    const parts = at("command-find").value.toLowerCase().split(" ");
    const found = this.rows.filter(({ words }) => parts.every((part) => words.toLowerCase().includes(part)));
    at("command-rows").replaceChildren(
      ...found.map(({ words, keys = "", act }) => {
        const made = element("button", words, { type: "button" });
        made.append(element("kbd", keys));
        made.onclick = () => {
          at("commands").close();
          act();
        };
        return made;
      }),
    );
  }

  // Arrows walk through the list, Enter takes what is first.
  walk(event) {
    const rows = [at("command-find"), ...at("command-rows").children];
    const row = rows.indexOf(document.activeElement);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && row >= 0) {
      event.preventDefault();
      rows[Math.max(0, Math.min(rows.length - 1, row + step))].focus();
    } else if (event.key === "Enter" && row === 0) {
      event.preventDefault();
      rows[1]?.click();
    }
  }
}

// The commands of a page: what its buttons, lists and pictures do.
export function commandsOf({ hello, panel, show, choosePerson }) {
  const press = (id, words, keys = "") => ({ words, keys, act: () => at(id).click(), off: at(id).disabled });
  const bar = [...(panel?.bar.querySelectorAll("button") ?? [])].filter((one) => one.textContent !== "?");
  const rows = [
    press("undo", "Undo", "Ctrl Z"),
    press("redo", "Redo", "Ctrl Shift Z"),
    press("save", at("save").textContent, "Ctrl S"),
    ...[...hello.cases, ...hello.motions].map((name) => ({ words: `Case: ${name}`, act: () => show(name) })),
    ...hello.people.map(({ role }, k) => ({ words: `Person: ${role}`, act: () => choosePerson(k) })),
    ...bar.map((one) => ({ words: `Picture: ${one.textContent}`, act: () => one.click() })),
    ...[...document.querySelectorAll("input[name=grip]")].map((one) => ({
      words: `Drag: ${one.parentElement.textContent.trim()}`,
      act: () => one.click(),
      off: one.disabled,
    })),
    { words: "Predict the posture", act: () => at("predict").requestSubmit(), off: at("prediction").hidden },
    { ...press("free", "Free the seat"), off: at("free").disabled || at("prediction").hidden },
    { ...press("mirror", "Mirror left and right"), off: at("posture-form").hidden },
    { ...press("envelope-ask", "Envelope of the hand"), off: at("limb").hidden },
    press("pair-points", "Measure two points"),
    press("report-make", "Make the report", "R"),
    { ...press("report-ask", at("report-ask").textContent), off: at("report-one").hidden || at("report-ask").disabled },
    { ...press("report-end", "End the report that is being made"), off: at("report-going").hidden },
    press("help", "Keys", "?"),
  ];
  return rows.filter((one) => !one.off);
}
