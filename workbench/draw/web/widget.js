// The turnable picture as a widget of a notebook: Python and all places that show the widget share
// one state, the model (see widget.py).

import { VIEWS } from "./camera.js";
import { element } from "./list.js";
import { areAlike, centreAt, chosenOf, isDark, isSame, namesOf, sectionOf, sectionWords } from "./naming.js";
import { Panel } from "./panel.js";
import { named } from "./pick.js";
import { readBlock, sceneOf } from "./wire.js";

const AWAY = "1500px"; // from the window, where a picture gives its context back
const STATE = ["look_from", "section", "hidden", "see_through_walls", "selected"];

class Widget {
  constructor(model, el) {
    Object.assign(this, { model, panel: null, before: null, asked: 0, told: {} });
    this.said = element("p", { className: "said" });
    this.place = element("div", { className: "turn" }, element("p", { className: "still" }), this.said);
    this.root = element("div", { className: "workbench" }, this.place);
    this.root.dataset.lmSuppressShortcuts = "true"; // of JupyterLab, where x cuts a cell
    this.root.dataset.jpSuppressContextMenu = "true";
    this.root.addEventListener("keydown", (event) => {
      if (event.defaultPrevented || event.target.matches("input")) event.stopPropagation();
    });
    el.append(this.root);
    this.listen();
    this.watchTheme();
    this.watch = new IntersectionObserver((seen) => this.near(seen.at(-1).isIntersecting), {
      rootMargin: AWAY,
      scrollMargin: AWAY,
    });
    this.watch.observe(this.root);
    this.grow();
  }

  listen() {
    this.heard = Object.entries({
      _scene: () => this.load(),
      picture: () => this.load(),
      _people: () => this.takePeople(),
      height: () => this.grow(),
    });
    for (const name of STATE) this.heard.push([name, () => this.take(name)]);
    for (const [name, act] of this.heard) this.model.on(`change:${name}`, act);
    this.place.addEventListener("chosen", () => this.report());
    this.place.addEventListener("case", (event) => this.turnTo(this.model.get("picture") + event.detail));
  }

  grow() {
    this.root.style.setProperty("--tall", `${this.model.get("height")}px`);
  }

  // Light or dark as what stands behind the picture: each kind of notebook has a theme of its own.
  watchTheme() {
    const change = () => {
      this.dark = isDark(this.root);
      this.root.dataset.look = this.dark ? "dark" : "light";
      this.panel?.viewer.theme(this.dark);
    };
    this.themes = new MutationObserver(change);
    for (const one of [document.documentElement, document.body]) this.themes.observe(one, { attributes: true });
    this.system = matchMedia("(prefers-color-scheme: dark)");
    this.system.addEventListener("change", change);
    this.retheme = change;
    change();
  }

  // The picture is near the window, or it has gone away from it.
  near(isNear) {
    this.isNear = isNear;
    this.retheme(); // it was perhaps made before it was put into the page
    if (!isNear) this.shut();
    else if (!this.panel) this.load();
  }

  // Take what stands still, and the people, and show them as the picture before was seen.
  async load() {
    if (!this.isNear) return;
    const mine = ++this.asked;
    try {
      const page = await readBlock(this.model.get("_scene"));
      const people = await this.people();
      if (mine !== this.asked || !this.isNear) return; // something newer is on its way
      const picture = this.model.get("picture");
      const scene = sceneOf(page, picture);
      if (people) Object.assign(scene, { bodies: people, marks: [], times: null, gaps: null });
      this.open(scene, picture);
      this.titles = page.views.map((view) => view.title);
      if (this.titles.length > 1) this.panel.bar.prepend(this.chooser(picture));
    } catch (error) {
      this.said.textContent = `This picture can be turned where there is WebGL 2: ${error.message}.`;
    }
  }

  // The bodies that Python has put in place of those of the picture, null for none.
  async people() {
    const packed = this.model.get("_people");
    return packed?.byteLength ? sceneOf(await readBlock(packed), 0).bodies : null;
  }

  open(scene, picture) {
    this.shut();
    this.said.textContent = scene.title;
    this.panel = new Panel(this.place, scene, this.dark);
    if (this.before) this.panel.resume({ ...this.before, hiddenBodies: new Set(), hiddenParts: new Set() });
    else if (this.model.get("look_from")) this.panel.view(this.model.get("look_from"));
    this.picture = picture;
    this.told = this.state();
    for (const name of STATE.slice(1)) this.take(name);
    this.panel.viewer.addEventListener("frame", () => this.report());
  }

  // Give the context back, and keep how the picture was seen.
  shut() {
    if (!this.panel) return;
    const { camera, section, walls } = this.panel.viewer;
    this.panel.leave();
    this.before = { camera, section, walls };
    this.panel.end();
    this.panel = null;
  }

  chooser(picture) {
    const made = this.titles.map((title, k) => element("option", { value: k, textContent: title, selected: k === picture }));
    const chooser = element("select", {}, ...made);
    chooser.setAttribute("aria-label", "picture");
    chooser.onchange = () => this.turnTo(Number(chooser.value));
    return chooser;
  }

  turnTo(picture) {
    if (!this.titles?.[picture]) return;
    this.model.set("picture", picture);
    this.model.save_changes();
  }

  // Other people, or the same ones elsewhere: those are moved, and nothing else is touched.
  async takePeople() {
    if (!this.panel || this.picture !== this.model.get("picture")) return this.load();
    const mine = ++this.asked;
    const people = await this.people();
    if (mine !== this.asked || !this.panel) return;
    const { scene, viewer, film } = this.panel;
    if (film || !people || !areAlike(people, scene.bodies)) return this.load();
    people.forEach((body, k) => Object.assign(scene.bodies[k], body));
    scene.frame += 1; // the card takes them up
    const { chosen, labels } = this.panel;
    if (chosen?.kind === "body") {
      chosen.point = centreAt(scene.bodies[chosen.body], chosen.sphere);
      if (labels.aim) labels.aim = chosen.point;
    }
    viewer.moved();
  }

  // Put one thing of the state into the picture, unless it is there already.
  take(name) {
    const value = this.model.get(name);
    if (!this.panel || this.telling || isSame(value, this.told[name])) return;
    const { panel } = this;
    const { viewer, scene } = panel;
    if (name === "look_from" && value) panel.view(value);
    if (name === "see_through_walls") panel.setWalls(!value);
    if (name === "section") panel.setSection(value === null ? null : this.plane(value));
    if (name === "selected") this.select(value);
    if (name === "hidden") {
      const indices = (things) => new Set([...things.keys()].filter((k) => value.includes(things[k].name)));
      viewer.hiddenBodies = indices(scene.bodies);
      viewer.hiddenParts = indices(scene.place?.parts ?? []);
      viewer.partsChanged();
      if (panel.list) [0, 1].forEach(() => panel.toggleList()); // with the boxes as they are now
    }
    this.told[name] = value;
  }

  // "left=0.3" as a plane; "left" goes through the middle.
  plane(section) {
    const { axis, sign, at } = sectionOf(section);
    return this.panel.sectionAt(axis, sign, at ?? this.panel.middle()[axis]);
  }

  select(names) {
    const { panel } = this;
    panel.chosen = names.length ? chosenOf(panel.scene, names) : null;
    panel.labels.aim = panel.chosen?.point ?? null;
    panel.say(panel.chosen ? named(panel.scene, panel.chosen) : panel.words);
    panel.viewer.draw();
  }

  // The state as it is in this picture.
  state() {
    const { viewer, scene, chosen } = this.panel;
    const { azimuth, height } = viewer.camera;
    const names = (things, hidden) => things.filter((_, k) => hidden.has(k)).map(({ name }) => name);
    return {
      look_from: Object.keys(VIEWS).find((name) => VIEWS[name][0] === azimuth && VIEWS[name][1] === height) ?? "",
      section: viewer.section && sectionWords(viewer.section),
      hidden: [...names(scene.bodies, viewer.hiddenBodies), ...names(scene.place?.parts ?? [], viewer.hiddenParts)],
      see_through_walls: !viewer.walls,
      selected: chosen ? namesOf(scene, chosen) : [],
    };
  }

  // Tell Python what has been changed by hand.
  report() {
    if (!this.panel) return;
    const now = this.state();
    const changed = STATE.filter((name) => !isSame(now[name], this.told[name]));
    if (!changed.length) return;
    this.telling = true;
    for (const name of changed) this.model.set(name, now[name]);
    this.telling = false;
    this.told = now;
    this.model.save_changes();
  }

  end() {
    this.isNear = false;
    this.asked += 1;
    for (const [name, act] of this.heard) this.model.off(`change:${name}`, act);
    this.watch.disconnect();
    this.themes.disconnect();
    this.system.removeEventListener("change", this.retheme);
    this.shut();
    this.root.remove();
  }
}

export default {
  render({ model, el }) {
    const widget = new Widget(model, el);
    return () => widget.end();
  },
};
