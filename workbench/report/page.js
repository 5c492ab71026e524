// Tables that are searched and sorted, values of curves, and folded parts that open where they are
// wanted. The page reads without any of it.
"use strict";

const LEAST_ROWS = 8; // a table with fewer rows needs no search

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

// A cell as a number, or NaN: "1,512 mm", "−12", "under 1 %".
function numberOf(text) {
  const found = /^(under|over)?\s*([-−+]?[\d,]*\.?\d+)/.exec(text);
  return found ? Number(found[2].replace(/,/g, "").replace("−", "-")) : NaN;
}

function compare(one, two) {
  const [a, b] = [numberOf(one), numberOf(two)];
  if (!Number.isNaN(a) && !Number.isNaN(b)) return a - b;
  if (Number.isNaN(a) !== Number.isNaN(b)) return Number.isNaN(a) ? 1 : -1;
  return one < two ? -1 : one > two ? 1 : 0;
}

function sortable(table) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    if (head.classList.contains("chart") || !head.textContent.trim()) return;
    const button = make("button", { type: "button", title: "sort by this column" }, ...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = (row) => row.cells[column].textContent.trim();
      const rows = [...table.tBodies[0].rows];
      rows.sort((a, b) => (down ? -1 : 1) * compare(text(a), text(b)));
      table.tBodies[0].append(...rows);
    });
  });
}

function searchable(table) {
  const rows = [...table.tBodies[0].rows];
  if (rows.length < LEAST_ROWS) return;
  const words = table.caption ? table.caption.firstChild.textContent.trim() : "this table";
  const field = make("input", { type: "search", placeholder: "search", ariaLabel: `search: ${words}` });
  const count = make("output", {});
  field.addEventListener("input", () => {
    const wanted = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let left = 0;
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      row.hidden = !wanted.every((word) => text.includes(word));
      left += row.hidden ? 0 : 1;
    }
    count.textContent = wanted.length ? `${left} of ${rows.length} rows` : "";
  });
  (table.closest(".scroll") || table).before(make("p", { className: "search" }, field, " ", count));
}

// The value of a polyline at x, from the points that it is drawn through; NaN beside it.
function heightAt(points, x) {
  for (let k = 1; k < points.length; k += 1) {
    const [[x0, y0], [x1, y1]] = [points[k - 1], points[k]];
    if (x0 <= x && x <= x1) return x1 > x0 ? y0 + ((y1 - y0) * (x - x0)) / (x1 - x0) : y0;
  }
  return NaN;
}

function readable(svg) {
  const [left, right, start, end] = svg.dataset.across.split(" ").map(Number);
  const [top, bottom, high, low] = svg.dataset.down.split(" ").map(Number);
  const lines = [...svg.querySelectorAll("polyline[data-name]")].map((line) => ({
    name: line.dataset.name,
    points: line.getAttribute("points").split(" ").map((point) => point.split(",").map(Number)),
  }));
  const said = make("p", { className: "read", ariaLive: "polite" }, "Values: move over the chart, or use the arrow keys.");
  svg.closest(".curve").append(said);
  const ruler = svg.querySelector("path").cloneNode();
  ruler.removeAttribute("stroke");
  ruler.setAttribute("d", "");
  ruler.setAttribute("class", "ruler");
  svg.append(ruler);
  svg.setAttribute("tabindex", "0");
  let at = left;
  const show = (x) => {
    at = Math.min(Math.max(x, left), right);
    ruler.setAttribute("d", `M${at.toFixed(1)} ${top}V${bottom}`);
    const time = start + ((end - start) * (at - left)) / (right - left);
    const values = lines.map(({ name, points }) => {
      const value = high + ((low - high) * (heightAt(points, at) - top)) / (bottom - top);
      return `${name} ${value.toFixed(Math.abs(high - low) < 20 ? 2 : 0)}`;
    });
    said.textContent = `${time.toFixed(1)} ms [${svg.dataset.unit}]: ${values.join("; ")}`;
  };
  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    show(((event.clientX - box.left) * svg.viewBox.baseVal.width) / box.width);
  });
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    show(at + (step * (right - left)) / 100);
  });
}

// Opens what is folded around, or at the head of, the place that a link leads to.
function unfold() {
  const name = decodeURIComponent(location.hash.slice(1));
  const place = name && document.getElementById(name);
  if (!place) return;
  const own = place.querySelector(":scope > details.folded");
  if (own) own.open = true;
  for (let box = place.parentElement; box; box = box.parentElement) {
    if (box.tagName === "DETAILS") box.open = true;
  }
}

let opened = [];
addEventListener("beforeprint", () => {
  opened = [...document.querySelectorAll("details:not([open])")];
  for (const box of opened) box.open = true;
});
addEventListener("afterprint", () => opened.forEach((box) => { box.open = false; }));
addEventListener("hashchange", unfold);
document.querySelectorAll("table.data").forEach((table) => {
  sortable(table);
  searchable(table);
});
document.querySelectorAll("svg[data-across]").forEach(readable);
unfold();
