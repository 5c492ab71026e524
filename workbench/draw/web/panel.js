// One turnable picture with what belongs to it: buttons, names, labels, list of parts, time.

import { VIEWS } from "./camera.js";
import { Film } from "./film.js";
import { HELP, sliders } from "./help.js";
import { Labels } from "./labels.js";
import { element, partList } from "./list.js";
import { clearest, named, pick, same } from "./pick.js";
import { Touch } from "./touch.js";
import { Viewer } from "./viewer.js";
import { boundsOf, setFrame } from "./wire.js";
import { Wipe } from "./wipe.js";

const [BAD, GOOD] = [[200, 32, 26], [46, 124, 214]];
const AGAIN = 4; // pixels between two clicks at one place

export class Panel {
  // Paints: what paints the canvas, see viewer.js.
  constructor(place, scene, dark, Paints) {
    this.place = place;
    this.scene = scene;
    this.still = place.querySelector(".still");
    this.said = place.querySelector(".said");
    this.words = this.said.textContent;
    const canvas = element("canvas", { tabIndex: 0 });
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${scene.title}; can be turned with the arrow keys`);
    this.over = element("div", { className: "over" });
    this.tip = element("span", { className: "tip", hidden: true });
    this.stage = element("div", { className: "stage" }, canvas, this.over);
    this.bar = element("div", { className: "bar" });
    this.still.before(this.bar, this.stage);
    this.still.hidden = true;
    this.still.style.display = "none";
    try {
      this.viewer = new Viewer(canvas, scene, Paints);
    } catch (error) {
      this.end();
      throw error;
    }
    this.labels = new Labels(this);
    this.over.append(this.tip);
    this.buttons();
    if (scene.times) {
      this.film = new Film({
        times: scene.times,
        words: scene.clock ?? ((time) => `${time.toFixed(1)} ms`),
        show: (frame) => {
          this.at(frame);
          this.viewer.moved();
        },
        ready: scene.ready,
      });
      this.stage.after(this.film.bar);
      if (scene.gaps) this.film.gaps(scene.gaps);
    }
    if (scene.states) {
      this.wipe = new Wipe(scene.states, (wipe) => {
        this.viewer.wipe = wipe;
        this.viewer.moved();
      });
      this.over.append(this.wipe.line);
      this.stage.after(this.wipe.bar);
      this.wipe.at(0.5);
    }
    this.touch = new Touch(this);
    this.viewer.addEventListener("frame", () => this.labels.place());
    this.viewer.theme(dark);
    this.at(this.scene.begin ?? 0);
    this.view();
    const how = sliders(scene);
    if (this.words && how) this.said.append(element("span", { className: "how", textContent: `; ${how}` }));
    this.said.setAttribute("aria-live", "polite");
  }

  button(words, act, pressed) {
    const made = element("button", { type: "button", textContent: words, onclick: act });
    if (pressed !== undefined) made.setAttribute("aria-pressed", pressed);
    this.bar.append(made);
    return made;
  }

  buttons() {
    for (const name of Object.keys(VIEWS)) this.button(name, () => this.view(name));
    this.button("fit", () => this.fit());
    this.bar.append(element("span", { className: "space" }));
    if (this.scene.place) {
      this.wallButton = this.button("see-through walls", () => this.setWalls(), true);
    }
    this.sectionButton = this.button("section", () => this.toggleSection(), false);
    if (this.scene.place || this.scene.bodies.length > 1) {
      this.listButton = this.button("parts", () => this.toggleList(), false);
    }
    this.button("?", () => this.say(HELP));
  }

  view(name = this.scene.from || "corner") {
    this.leave();
    this.viewer.camera.look(...VIEWS[name]);
    this.viewer.fit();
  }

  // Look at all of it, from where the camera looks.
  fit() {
    this.leave();
    this.viewer.fit();
  }

  // Look at what was clicked.
  focus() {
    if (this.chosen) this.lookAt(this.chosen.point);
  }

  // Whether walls before a body are opaque; the other way if not told.
  setWalls(walls = !this.viewer.walls) {
    this.viewer.walls = walls;
    this.wallButton?.setAttribute("aria-pressed", !walls);
    this.viewer.draw();
  }

  // Look as another viewer did.
  resume({ camera, section, walls, hiddenBodies, hiddenParts }) {
    const { viewer } = this;
    Object.assign(viewer.camera, camera);
    Object.assign(viewer, { hiddenBodies, hiddenParts });
    this.setWalls(walls);
    this.setSection(section);
    viewer.partsChanged();
  }

  lookedAt = () => this.viewer.camera.at;
  // A section square to the axis nearest to the view, through what was clicked last or is looked at.
  toggleSection() {
    if (this.viewer.section) return this.setSection(null);
    const { z } = this.viewer.camera.axes();
    const axis = z.map(Math.abs).indexOf(Math.max(...z.map(Math.abs)));
    this.setSection(this.sectionAt(axis, Math.sign(z[axis]) || 1, (this.chosen?.point ?? this.lookedAt())[axis]));
  }

  // The plane across an axis at a coordinate; what is on the side of the sign goes.
  sectionAt(axis, sign, at) {
    const plane = [0, 0, 0, -sign * at];
    plane[axis] = sign;
    return plane;
  }

  middle() {
    const [low, high] = boundsOf(this.scene);
    return low.map((value, k) => (value + high[k]) / 2);
  }

  // A plane [a, b, c, d], or null for none.
  setSection(plane) {
    this.viewer.section = plane;
    this.sectionButton.setAttribute("aria-pressed", Boolean(plane));
    const axis = plane ? plane.findIndex((value, k) => k < 3 && value) : -1;
    this.sectionButton.title = plane ? `cut at ${"xyz"[axis]} ${Math.round((-1000 * plane[3]) / plane[axis])} mm` : "";
    this.at(this.scene.frame);
  }

  toggleList() {
    if (this.list) this.list.remove();
    this.list = this.list ? null : partList(this.viewer, this.scene);
    if (this.list) this.stage.append(this.list);
    this.listButton.setAttribute("aria-pressed", Boolean(this.list));
  }

  at(frame) {
    this.film?.at(frame);
    if (this.scene.ready && !this.scene.ready(frame)) return; // shown when it has come
    setFrame(this.scene, frame);
    const there = this.labels.there();
    const lines = this.scene.marks.filter((mark, k) => mark.to && there[k]);
    this.viewer.setMarks(lines.map((mark) => ({ ...mark, colour: mark.failing ? BAD : GOOD })));
    if (this.film?.playing) this.viewer.moved();
  }

  toggle() {
    this.film?.toggle();
  }

  // Look from an eye { at, sight, up }, this angle [rad] high; views, fit and Esc leave it.
  stand(eye, angle) {
    this.viewer.camera.stand(eye, angle);
    this.viewer.draw();
  }

  // Whether the picture was seen from an eye; it is no longer.
  leave() {
    const stood = this.viewer.camera.leave();
    if (stood) this.place.dispatchEvent(new CustomEvent("left", { bubbles: true }));
    this.viewer.draw();
    return stood;
  }

  under(x, y) {
    const { viewer, scene } = this;
    const box = viewer.canvas.getBoundingClientRect();
    const across = (x - box.left) / box.width;
    const ray = viewer.camera.ray(2 * across - 1, 1 - (2 * (y - box.top)) / box.height);
    return pick(scene, ray, viewer.shownAt(across), viewer.section, !viewer.walls);
  }

  hover(x, y) {
    const hit = this.under(x, y);
    this.tip.hidden = !hit;
    if (!hit) return;
    const box = this.viewer.canvas.getBoundingClientRect();
    this.tip.textContent = named(this.scene, hit);
    this.tip.style.left = `${x - box.left}px`;
    this.tip.style.top = `${y - box.top}px`;
  }

  choose(x, y) {
    const hit = this.under(x, y);
    const again = this.clicked && Math.hypot(x - this.clicked[0], y - this.clicked[1]) < AGAIN;
    this.clicked = [x, y];
    this.chosen = again && hit?.before && same(hit, this.chosen) ? hit.before : hit;
    this.say(this.chosen ? named(this.scene, this.chosen) : this.words);
    this.place.dispatchEvent(new CustomEvent("chosen", { bubbles: true, detail: this.chosen }));
  }

  lookAt(point, time) {
    const { viewer } = this;
    this.leave();
    if (time && this.scene.times) {
      const late = this.scene.times.findIndex((each) => each >= Number(time) - 1e-6);
      this.at(late < 0 ? this.scene.times.length - 1 : late);
    }
    const solid = (k) => viewer.shown.part(k) && !this.scene.place.parts[k].glass;
    const shown = { body: viewer.shown.body, part: solid };
    const { azimuth, height } = clearest(this.scene, viewer.camera, point, shown, viewer.section);
    this.labels.aim = point;
    Object.assign(viewer.camera, { at: point, azimuth, height, far: 1.1 });
    viewer.draw();
  }

  say(words) {
    this.said.textContent = words;
  }

  end() {
    this.film?.stop();
    this.viewer?.end();
    for (const made of [this.bar, this.stage, this.film?.bar, this.wipe?.bar]) made?.remove();
    this.still.hidden = false;
    this.still.style.display = "";
    this.said.textContent = this.words;
  }
}
