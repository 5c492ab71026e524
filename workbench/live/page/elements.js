// Making elements of the page, and its keys. Words of files are only ever written as text.

import { plain } from "/view/pick.js";

export const at = (id) => document.getElementById(id);

export function element(name, words = "", more = {}) {
  const made = document.createElement(name);
  made.textContent = words;
  return Object.assign(made, more);
}

// words: how a name is written; names of files stand as they are.
export function options(select, names, chosen, words = plain) {
  const same = names.length === select.children.length && names.every((name, k) => select.children[k].value === name);
  if (!same) select.replaceChildren(...names.map((name) => element("option", words(name), { value: name }))); // an open list stays open
  if (chosen !== undefined) select.value = chosen;
}

/* ---- what is typed ---- */

// A field whose text the bench has not taken yet is held: typed, sent, or refused. What is shown
// meanwhile does not write over it.
const TEXT = "input:not([type]), input[type=text], input[type=number]";

function hold(field, how, words = "") {
  if (how) field.dataset.held = how;
  else delete field.dataset.held;
  field.setAttribute("aria-invalid", how === "refused");
  field.title = words;
}

// Show a value in a field, unless something else was typed there.
export function put(field, value) {
  field.dataset.shown = value;
  if (!field.dataset.held) field.value = value;
}

// Let go of what was typed in a field, and show again what holds.
export function release(field) {
  hold(field, "");
  if (field.dataset.shown !== undefined) field.value = field.dataset.shown;
}

// A text that cannot be taken stays in its field, with the reason, until it is typed anew or Esc is pressed.
export function refuse(field, words) {
  hold(field, "refused", `${words} (Esc: back to what holds)`);
}

// Send what was typed in a field. send: is given what is to be called with the answer.
export function sendTyped(field, send) {
  hold(field, "sent");
  send((head) => {
    if (field.dataset.held !== "sent") return; // typed anew meanwhile
    if (head?.kind === "fault" && field.value) refuse(field, head.words);
    else release(field);
  });
}

// What is being typed counts as typed to the end.
export function commit() {
  const field = document.activeElement;
  if (!field?.dataset.held) return;
  field.blur();
  field.focus();
}

// The fields of a page with what the bench has not taken.
export const heldFields = () => [...document.querySelectorAll("[data-held]")];

// Ask before a page is left; unsaved: whether something would be lost.
export function guardLeaving(unsaved) {
  addEventListener("beforeunload", (event) => {
    if (!unsaved()) return;
    event.preventDefault();
    event.returnValue = true; // browsers before 2023 heed this alone
  });
}

function watchTyping() {
  addEventListener("input", ({ target }) => {
    if (target.matches?.(TEXT) && !target.matches("[data-setting]")) hold(target, "typed");
  });
  // What nothing was asked for is taken with its change, but for a draft, which a button takes.
  addEventListener("change", ({ target }) => {
    if (target.dataset?.held === "typed" && !target.matches("[data-draft]")) hold(target, "");
  });
  addEventListener("keydown", ({ key, target }) => {
    if (key === "Escape" && target.dataset?.held) release(target);
  });
}

// Undo, redo and save by their keys and buttons: Ctrl-Z, Ctrl-Shift-Z or Ctrl-Y, Ctrl-S.
export function bindHistory(verbs) {
  watchTyping();
  for (const [verb, does] of Object.entries(verbs)) at(verb).onclick = () => does();
  addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    const key = event.key.toLowerCase();
    const verb = { z: event.shiftKey ? "redo" : "undo", y: "redo", s: "save" }[key];
    if (!verb) return;
    if (verb !== "save" && event.target.dataset?.held === "typed") return; // of the field alone
    event.preventDefault();
    if (verb === "save") commit();
    verbs[verb]();
  });
}
