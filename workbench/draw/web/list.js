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
  find.oninput = () => {
    for (const one of rows) one.hidden = !one.textContent.includes(find.value.trim().toLowerCase());
    for (const one of rows) one.style.display = one.hidden ? "none" : "";
  };
  return element("div", { className: "list" }, find, ...rows);
}
