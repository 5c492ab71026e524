// Making elements of the page, and its keys. Words of files are only ever written as text.

export const at = (id) => document.getElementById(id);

export function element(name, words = "", more = {}) {
  const made = document.createElement(name);
  made.textContent = words;
  return Object.assign(made, more);
}

export function options(select, names, chosen) {
  select.replaceChildren(...names.map((name) => element("option", name, { value: name })));
  if (chosen !== undefined) select.value = chosen;
}

// Undo, redo and save by their keys and buttons: Ctrl-Z, Ctrl-Shift-Z or Ctrl-Y, Ctrl-S.
export function bindHistory(verbs) {
  for (const [verb, does] of Object.entries(verbs)) at(verb).onclick = () => does();
  addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    const key = event.key.toLowerCase();
    const verb = { z: event.shiftKey ? "redo" : "undo", y: "redo", s: "save" }[key];
    if (!verb) return;
    event.preventDefault();
    verbs[verb]();
  });
}
