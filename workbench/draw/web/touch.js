// Mouse, fingers and keys of one turnable picture.

import { VIEWS } from "./camera.js";

const TURN = 0.008; // radians a pixel
const STEP = 0.08; // radians a key
export const CLICK = 4; // pixels that a click may move
const PAUSE = 60; // milliseconds that the mouse rests before a name appears

export class Touch {
  constructor(panel) {
    this.panel = panel;
    this.fingers = new Map();
    this.way = 0;
    const { canvas } = panel.viewer;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event, true));
    canvas.addEventListener("pointercancel", (event) => this.up(event, false));
    canvas.addEventListener("pointerleave", () => this.leave());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  down(event) {
    const { canvas } = this.panel.viewer;
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (!this.fingers.size) this.way = 0;
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    this.leave();
  }

  move(event) {
    const { clientX: x, clientY: y } = event;
    const before = this.fingers.get(event.pointerId);
    if (!before) {
      clearTimeout(this.pause);
      this.pause = setTimeout(() => this.panel.hover(x, y), PAUSE);
      return;
    }
    const { viewer } = this.panel;
    const [dx, dy] = [x - before[0], y - before[1]];
    this.way += Math.abs(dx) + Math.abs(dy);
    const high = viewer.canvas.clientHeight;
    if (this.fingers.size === 2) {
      const other = [...this.fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = Math.hypot(x - other[0], y - other[1]) || 1;
      viewer.camera.zoom(Math.hypot(before[0] - other[0], before[1] - other[1]) / apart);
      viewer.camera.pan(dx / 2 / high, -dy / 2 / high);
    } else if (event.shiftKey || event.buttons & 6) viewer.camera.pan(dx / high, -dy / high);
    else viewer.camera.turn(-dx * TURN, dy * TURN);
    this.fingers.set(event.pointerId, [x, y]);
    viewer.moved();
  }

  up(event, chosen) {
    if (!this.fingers.delete(event.pointerId)) return;
    if (chosen && this.way < CLICK) this.panel.choose(event.clientX, event.clientY);
  }

  leave() {
    clearTimeout(this.pause);
    this.panel.tip.hidden = true;
  }

  // A page scrolls on under the mouse until its picture was clicked.
  wheel(event) {
    const { canvas } = this.panel.viewer;
    const focused = canvas.getRootNode().activeElement; // in a notebook's shadow tree the document's is its host
    if (focused !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    this.panel.viewer.camera.zoom(Math.exp(event.deltaY * 0.001));
    this.panel.viewer.moved();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const act = this.acts(event.shiftKey ? 10 * STEP : STEP)[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
    this.panel.viewer.moved();
  }

  acts(step) {
    const { panel } = this;
    const { viewer } = panel;
    const left = viewer.camera.orbit ? -step : step; // an eye looks to the left, a picture is turned so
    const acts = {
      arrowleft: () => viewer.camera.turn(left, 0),
      arrowright: () => viewer.camera.turn(-left, 0),
      arrowup: () => viewer.camera.turn(0, step),
      arrowdown: () => viewer.camera.turn(0, -step),
      "+": () => viewer.camera.zoom(0.9),
      "-": () => viewer.camera.zoom(1 / 0.9),
      0: () => panel.fit(),
      f: () => panel.focus(),
      h: () => this.hide(),
      i: () => this.isolate(),
      x: () => panel.setWalls(),
      c: () => panel.toggleSection(),
      "[": () => this.other(-1),
      "]": () => this.other(1),
      " ": () => panel.toggle(),
      "?": () => panel.bar.lastChild.click(),
      escape: () => panel.leave() || this.restore(),
    };
    Object.keys(VIEWS).forEach((name, k) => {
      acts[k + 1] = () => panel.view(name);
    });
    return acts;
  }

  hide() {
    const { chosen, viewer } = this.panel;
    if (!chosen) return;
    if (chosen.kind === "part") viewer.hiddenParts.add(chosen.part);
    else viewer.hiddenBodies.add(chosen.body);
    viewer.partsChanged();
  }

  // Everything else goes; the bodies stay where a part was chosen.
  isolate() {
    const { chosen, viewer, scene } = this.panel;
    if (!chosen) return;
    (scene.place ? scene.place.parts : []).forEach((_, k) => {
      if (chosen.kind !== "part" || chosen.part !== k) viewer.hiddenParts.add(k);
    });
    if (chosen.kind === "body") {
      scene.bodies.forEach((_, k) => {
        if (k !== chosen.body) viewer.hiddenBodies.add(k);
      });
    }
    viewer.partsChanged();
  }

  restore() {
    const { panel } = this;
    panel.viewer.hiddenParts.clear();
    panel.viewer.hiddenBodies.clear();
    panel.chosen = null;
    panel.labels.aim = null;
    if (panel.viewer.section) panel.toggleSection();
    panel.say(panel.words);
    panel.viewer.partsChanged();
    panel.view();
  }

  other(step) {
    this.panel.place.dispatchEvent(new CustomEvent("case", { bubbles: true, detail: step }));
  }
}
