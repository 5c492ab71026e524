// Three arrows at what is chosen, by which it is dragged, and its middle, by which it goes freely in
// the plane of the picture. What is dragged is a grip: { at, axes, free, drag(by, done) }.

import { vec } from "/view/camera.js";
import { CLICK } from "/view/touch.js";
import { alongAxis, handleAt, inPlane } from "./ways.js";

const COLOURS = [
  [206, 84, 20],
  [24, 128, 72],
  [44, 96, 214],
];
const MIDDLE = [232, 160, 19];
const CROSS = [150, 60, 170];
const SIZE = 0.11; // of the distance of the eye
const REACH = 11; // pixels
const FINGER = 22; // pixels, of a finger

export class Gizmo {
  // drop: is called where a drag is given up.
  constructor(drop) {
    Object.assign(this, { drop, panel: null, grip: null, crosses: [], drag: null, drawn: "" });
    addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !this.drag) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      this.end();
      this.drop();
    }, true);
  }

  // Take the picture that is there now.
  attach(panel) {
    this.panel = panel;
    this.drawn = "";
    const { stage, viewer } = panel;
    stage.addEventListener("pointerdown", (event) => this.down(event), true);
    stage.addEventListener("pointermove", (event) => this.move(event), true);
    stage.addEventListener("pointerup", (event) => this.up(event), true);
    stage.addEventListener("pointercancel", (event) => this.up(event), true);
    // Else the page scrolls where a finger drags up or down, and the browser takes the pointer away.
    stage.addEventListener("touchstart", (event) => this.drag && event.preventDefault(), { passive: false });
    viewer.stroke = 1.8;
    viewer.addEventListener("frame", () => this.draw());
    this.draw();
  }

  // What is to be dragged, null for nothing; and points that are marked [m].
  aim(grip, crosses = []) {
    this.grip = grip;
    this.crosses = crosses;
    this.draw();
  }

  get size() {
    const { camera } = this.panel.viewer;
    return SIZE * (camera.orbit ? 1 : camera.far); // an eye is about an arm away
  }

  draw() {
    if (!this.panel) return;
    const seen = this.grip && this.seen(this.grip.at);
    const tips = this.grip?.axes.map((axis) => this.seen(vec.add(this.grip.at, vec.mul(axis, this.size))));
    this.panel.stage.dataset.grip = seen ? JSON.stringify([seen, ...tips]) : "";
    const key = JSON.stringify([this.grip?.at, this.grip?.axes, this.crosses, this.size]);
    if (key === this.drawn) return;
    this.drawn = key;
    this.panel.viewer.setMarks(this.crosses.flatMap((at) => cross(at, 0.2 * this.size, CROSS)), "crosses");
    const lines = [];
    if (this.grip) {
      this.grip.axes.forEach((axis, k) => lines.push(...arrow(this.grip.at, axis, this.size, COLOURS[k])));
      if (this.grip.free) lines.push(...cross(this.grip.at, 0.1 * this.size, MIDDLE));
    }
    this.panel.viewer.setMarks(lines, "gizmo");
  }

  // Where a point is seen, in pixels of the picture.
  seen(point) {
    const { canvas, camera } = this.panel.viewer;
    const at = camera.project(point);
    return at && [(0.5 + 0.5 * at[0]) * canvas.clientWidth, (0.5 - 0.5 * at[1]) * canvas.clientHeight];
  }

  pointer(event) {
    const box = this.panel.viewer.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  ray(event) {
    const { canvas, camera } = this.panel.viewer;
    const [x, y] = this.pointer(event);
    return camera.ray((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight);
  }

  down(event) {
    if (this.drag) event.stopPropagation(); // another finger: the picture stays as it is
    if (!this.grip || this.drag || event.button || !event.isPrimary) return;
    const { at, axes, free } = this.grip;
    const tips = axes.map((axis) => this.seen(vec.add(at, vec.mul(axis, this.size))));
    const reach = event.pointerType === "touch" ? FINGER : REACH;
    const start = this.pointer(event);
    const handle = handleAt(start, this.seen(at), tips, reach);
    if (handle === null || (handle === "free" && !free)) return;
    const { grip } = this;
    const normal = this.panel.viewer.camera.axes().z;
    const from = this.point({ handle, at, axes, normal }, event);
    if (!from) return;
    event.stopPropagation();
    event.preventDefault();
    this.panel.stage.setPointerCapture(event.pointerId);
    this.drag = { pointer: event.pointerId, start, handle, at, axes, normal, from, grip, by: null };
  }

  // The point that a pointer drags to, on the arrow or in the plane.
  point({ handle, at, axes, normal }, event) {
    const ray = this.ray(event);
    if (handle === "free") return inPlane(at, normal, ray);
    const far = alongAxis(at, axes[handle], ray);
    return far === null ? null : vec.add(at, vec.mul(axes[handle], far));
  }

  move(event) {
    if (!this.drag) return;
    event.stopPropagation();
    if (event.pointerId !== this.drag.pointer) return;
    const [x, y] = this.pointer(event);
    const [fromX, fromY] = this.drag.start;
    if (!this.drag.by && Math.hypot(x - fromX, y - fromY) < CLICK) return; // not dragged yet
    const to = this.point(this.drag, event);
    if (!to) return;
    this.drag.by = vec.sub(to, this.drag.from);
    this.drag.grip.drag(this.drag.by, false);
  }

  up(event) {
    if (!this.drag) return;
    event.stopPropagation();
    if (event.pointerId !== this.drag.pointer) return;
    const { grip, by } = this.drag;
    this.end();
    if (event.type === "pointercancel") this.drop();
    else if (by) grip.drag(by, true);
    else this.panel.choose(event.clientX, event.clientY); // it was a click
  }

  end() {
    this.drag = null;
  }
}

// A cross of three lines at a point.
export function cross(at, size, colour) {
  return [0, 1, 2].map((k) => {
    const arm = [0, 0, 0];
    arm[k] = size;
    return { from: vec.sub(at, arm), to: vec.add(at, arm), colour };
  });
}

function arrow(at, axis, size, colour) {
  const tip = vec.add(at, vec.mul(axis, size));
  const side = Math.abs(axis[2]) > 0.9 ? [1, 0, 0] : vec.unit(vec.cross(axis, [0, 0, 1]));
  const barb = (way) => vec.add(vec.add(at, vec.mul(axis, 0.82 * size)), vec.mul(side, way * 0.07 * size));
  return [
    { from: at, to: tip, colour },
    { from: tip, to: barb(1), colour },
    { from: tip, to: barb(-1), colour },
  ];
}
