// Making elements of the page. Words of files are only ever written as text.

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
