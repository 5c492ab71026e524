// The picture as a PNG: into the clipboard, or as a file where the browser does not let it go there.

import { element } from "./elements.js";

const HANDLES = ["gizmo"]; // lines that are for dragging and no part of the picture

// A name for a file, of words that stand for what is in it.
export function fileName(words, ending) {
  const plain = words.filter(Boolean).map((one) => one.replace(/[^\p{L}\p{N}.-]+/gu, "_").replace(/^[_.]+|_+$/g, ""));
  return `${plain.filter(Boolean).join("_") || "picture"}.${ending}`;
}

// Give the user a file.
export function download(address, name) {
  const link = element("a", "", { href: address, download: name, hidden: true });
  document.body.append(link);
  link.click();
  link.remove();
}

// The lines that a text is broken into; measure: the width of some words.
export function broken(text, width, measure) {
  const lines = [];
  for (const word of text.split(" ")) {
    const longer = lines.length ? `${lines[lines.length - 1]} ${word}` : word;
    if (!lines.length || measure(longer) > width) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  return lines;
}

// What is needed to draw the labels that are seen over a picture.
function labelsOf({ over, tip, viewer }) {
  const box = viewer.canvas.getBoundingClientRect();
  return [...over.children].flatMap((label) => {
    const { left, top, width, height } = label.getBoundingClientRect();
    if (label === tip || !width) return [];
    const { fontWeight, fontSize, fontFamily, ...style } = { ...getComputedStyle(label) };
    const radius = parseFloat(style.borderTopLeftRadius) * (style.borderTopLeftRadius.endsWith("%") ? width / 100 : 1);
    const { color, backgroundColor, borderTopColor, borderTopWidth, paddingLeft } = style;
    const font = `${fontWeight} ${fontSize} ${fontFamily}`;
    const line = 1.3 * parseFloat(fontSize);
    const [stroke, inset] = [borderTopWidth, paddingLeft].map(parseFloat);
    const place = { x: left - box.left, y: top - box.top, width, height, radius, stroke, inset, line };
    return [{ ...place, font, color, paper: backgroundColor, border: borderTopColor, text: label.textContent }];
  });
}

function drawLabel(on, { x, y, width, height, radius, stroke, inset, line, font, color, paper, border, text }) {
  on.beginPath();
  on.roundRect(x + stroke / 2, y + stroke / 2, width - stroke, height - stroke, radius);
  Object.assign(on, { font, fillStyle: paper, strokeStyle: border, lineWidth: stroke });
  on.fill();
  if (stroke) on.stroke();
  Object.assign(on, { fillStyle: color, textAlign: "center", textBaseline: "middle" });
  const lines = broken(text, width - 2 * inset + 1, (words) => on.measureText(words).width);
  lines.forEach((words, k) => on.fillText(words, x + width / 2, y + height / 2 + (k - (lines.length - 1) / 2) * line));
}

// A promise of the picture of a panel with its labels, { blob, width, height }.
export async function pngOf(panel) {
  const { viewer } = panel;
  viewer.dispatchEvent(new Event("frame")); // puts the labels where the picture will have them
  const labels = labelsOf(panel);
  const shot = await viewer.shot(HANDLES);
  const { width, height, data } = shot;
  const canvas = element("canvas", "", { width, height });
  const on = canvas.getContext("2d");
  on.putImageData(new ImageData(data, width, height), 0, 0);
  const ratio = width / viewer.canvas.clientWidth;
  on.scale(ratio, ratio);
  for (const label of labels) drawLabel(on, label);
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  if (!blob) throw new Error("this browser makes no PNG of it");
  return { blob, width, height };
}

export class Copying {
  // names: gives the words that name what is shown; say: is told what becomes of the picture.
  constructor(names, say) {
    Object.assign(this, { names, say, panel: null, busy: false });
  }

  attach(panel) {
    this.panel = panel;
    const button = panel.button("copy", () => this.copy());
    button.title = "P: copy the picture";
    panel.bar.querySelector(".space").before(button);
  }

  async copy() {
    if (this.busy) return;
    if (!this.panel) return this.say("there is no picture to copy", true);
    this.busy = true;
    try {
      this.say(await this.copied(pngOf(this.panel)));
    } catch (error) {
      this.say(`the picture could not be copied: ${error.message}`, true);
    }
    this.busy = false;
  }

  // Where the picture has gone, in words.
  async copied(made) {
    const size = ({ width, height }) => `${width} × ${height} pixels`;
    try {
      if (!navigator.clipboard?.write || !window.ClipboardItem) throw new Error("it has none here");
      await navigator.clipboard.write([new ClipboardItem({ "image/png": made.then(({ blob }) => blob) })]);
      return `copied: the picture is in the clipboard, ${size(await made)}`;
    } catch {
      const found = await made;
      const name = fileName(this.names(), "png");
      const address = URL.createObjectURL(found.blob);
      download(address, name);
      setTimeout(() => URL.revokeObjectURL(address), 60_000); // the browser reads it meanwhile
      return `downloaded as ${name}, ${size(found)}: this browser lets no picture into the clipboard`;
    }
  }
}
