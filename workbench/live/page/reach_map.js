// Reach maps of the population: the share of people who reach each point of a part, point by point.

import { plain } from "/view/pick.js";
import { element } from "./elements.js";

// Cividis: lighter is more people, to everybody's eyes.
const COLOURS = ["#00224e", "#434e6c", "#7d7c78", "#bcaf6f", "#fee838"];
const MARGIN = { left: 44, right: 12, top: 10, bottom: 34 };
const WIDTH = 380;
const NAMED = 14;
const SVG = "http://www.w3.org/2000/svg";


// The number of a share's band: how many levels it comes up to.
export function band(share, levels) {
  return levels.filter((level) => share >= level - 1e-9).length;
}

// The bands in words.
export function bands(levels) {
  const edges = levels.map((level) => `${Math.round(100 * level)}`);
  const between = edges.slice(1).map((high, k) => `${edges[k]} to ${high} %`);
  return [`under ${edges[0]} %`, ...between, `${edges.at(-1)} % and more`];
}

// Round values [mm] from low to high for the ticks of an axis.
export function ticks(low, high) {
  const step = [10, 20, 50, 100, 200, 500, 1000].find((each) => (high - low) / each <= 6) ?? 2000;
  const found = [];
  for (let at = Math.ceil(low / step) * step; at <= high; at += step) found.push(at);
  return found;
}

export class ReachMaps {
  constructor(box) {
    this.box = box;
  }

  show(head) {
    this.box.hidden = false;
    while (this.box.children.length <= head.map) this.box.append(element("figure"));
    this.box.children[head.map].replaceChildren(drawn(head), caption(head), key(head.levels));
  }

  forget() {
    this.box.hidden = true;
    this.box.replaceChildren();
  }
}

function drawn(head) {
  const frame = frameOf(head);
  const svg = shape("svg", { viewBox: `0 0 ${WIDTH} ${frame.height}`, role: "img", "aria-label": words(head) });
  const radius = Math.max(3, 0.75 * head.spacing * frame.scale);
  head.points.forEach((point, k) => {
    const fill = COLOURS[band(head.share[k], head.levels)];
    const disc = shape("circle", { cx: frame.x(point[0]), cy: frame.y(point[1]), r: radius, fill });
    disc.append(shape("title", {}, `${(100 * head.share[k]).toFixed(1)} %`));
    svg.append(disc);
  });
  axes(svg, frame);
  for (const [name, right, up] of head.controls) mark(svg, frame, name, right, up, head.controls.length <= NAMED);
  return svg;
}

// Where a map's millimetres are in the picture.
function frameOf({ points, controls, spacing }) {
  const all = [...points, ...controls.map(([, right, up]) => [right, up])];
  const [low, high] = [Math.min, Math.max].map((end) => [0, 1].map((axis) => end(...all.map((at) => at[axis]))));
  const border = 0.6 * spacing;
  const scale = (WIDTH - MARGIN.left - MARGIN.right) / (high[0] - low[0] + 2 * border);
  const height = MARGIN.top + MARGIN.bottom + scale * (high[1] - low[1] + 2 * border);
  const x = (right) => MARGIN.left + scale * (right - low[0] + border);
  const y = (up) => height - MARGIN.bottom - scale * (up - low[1] + border);
  return { low, high, scale, height, x, y };
}

function axes(svg, { low, high, height, x, y }) {
  for (const at of ticks(low[0], high[0])) {
    svg.append(shape("line", { class: "tick", x1: x(at), x2: x(at), y1: height - MARGIN.bottom, y2: height - MARGIN.bottom + 4 }));
    svg.append(shape("text", { x: x(at), y: height - MARGIN.bottom + 15, "text-anchor": "middle" }, `${at}`));
  }
  for (const at of ticks(low[1], high[1])) {
    svg.append(shape("line", { class: "tick", x1: MARGIN.left - 4, x2: MARGIN.left, y1: y(at), y2: y(at) }));
    svg.append(shape("text", { x: MARGIN.left - 7, y: y(at) + 4, "text-anchor": "end" }, `${at}`));
  }
  svg.append(shape("text", { x: WIDTH / 2, y: height - 4, "text-anchor": "middle" }, "mm to the right and up, from its middle"));
}

function mark(svg, { x, y }, name, right, up, named) {
  const d = `M${x(right) - 4} ${y(up)}h8M${x(right)} ${y(up) - 4}v8`;
  const cross = shape("path", { class: "control", d });
  cross.append(shape("title", {}, plain(name)));
  svg.append(shape("path", { class: "control under", d }), cross);
  if (named) svg.append(shape("text", { class: "control", x: x(right) + 6, y: y(up) - 4 }, plain(name)));
}

function caption(head) {
  const coarse = head.whole ? "" : `, ${head.points.length} points while it changes`;
  return element("figcaption", `${words(head)}: ${head.people} people${coarse}; obstacles aside`);
}

function words({ part, hand, grip, zone }) {
  return `The share who reach ${plain(part)} with ${hand}, ${grip}, zone ${zone}`;
}

function key(levels) {
  const line = element("p", "", { className: "key" });
  bands(levels).forEach((text, k) => {
    const item = element("span", "", { className: "item" });
    const swatch = shape("svg", { viewBox: "0 0 10 10", class: "swatch", "aria-hidden": "true" });
    swatch.append(shape("rect", { width: 10, height: 10, fill: COLOURS[k] }));
    item.append(swatch, element("span", text));
    line.append(item);
  });
  return line;
}

function shape(tag, attributes, text = "") {
  const found = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) found.setAttribute(name, value);
  if (text) found.textContent = text;
  return found;
}
