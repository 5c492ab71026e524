// The list of bodies and parts, with a box each that shows or hides it.

import { plain } from "./pick.js";

export function element(name, attributes = {}, ...inside) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...inside);
  return made;
}

// The list beside a picture, with a field that finds names.
export function partList(viewer, scene) {
  const find = element("input", { type: "search", placeholder: "find" });
  find.setAttribute("aria-label", "find a part");
  const row = (name, hidden, k) => {
    const box = element("input", { type: "checkbox", checked: !hidden.has(k) });
    box.onchange = () => {
      if (box.checked) hidden.delete(k);
      else hidden.add(k);
      viewer.partsChanged();
    };
    return element("label", {}, box, ` ${name}`);
  };
  const rows = scene.bodies.map((body, k) => row(body.name, viewer.hiddenBodies, k));
  for (const [k, part] of (scene.place ? scene.place.parts : []).entries()) {
    rows.push(row(plain(part.name), viewer.hiddenParts, k));
  }
  const list = element("div", {}, ...rows);
  list.setAttribute("role", "group");
  list.setAttribute("aria-label", "shown");
  const tabTo = oneTabStop(list);
  find.oninput = () => {
    for (const one of rows) one.hidden = !one.textContent.includes(find.value.trim().toLowerCase());
    for (const one of rows) one.style.display = one.hidden ? "none" : "";
    tabTo();
  };
  return element("div", { className: "list" }, find, list);
}

// One tab stop for all boxes of a list; up, down, Home and End go from one to another. Gives what is
// to be called when other boxes are there.
function oneTabStop(list) {
  const boxes = [...list.querySelectorAll("input")];
  const there = () => boxes.filter((box) => !box.parentElement.hidden);
  const stop = (chosen) => boxes.forEach((box) => (box.tabIndex = box === chosen ? 0 : -1));
  list.addEventListener("focusin", ({ target }) => stop(target));
  list.addEventListener("keydown", (event) => {
    const shown = there();
    const at = shown.indexOf(document.activeElement);
    const next = { ArrowUp: at - 1, ArrowDown: at + 1, Home: 0, End: shown.length - 1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    shown[Math.max(0, Math.min(shown.length - 1, next))]?.focus();
  });
  stop(boxes[0]);
  return () => there().some((box) => box.tabIndex === 0) || stop(there()[0]);
}
