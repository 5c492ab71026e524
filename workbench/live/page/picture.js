// The picture of the bench: the viewer of the reports, moved by the answers.

import { Panel } from "/view/panel.js";
import { isSoftware } from "/view/viewer.js";
import { coloured, readPage, sceneOf } from "/view/wire.js";
import { canPaintFar, FarPainting } from "./far_painting.js";

const TOUCHES = -1e-6; // room [m] below which a sphere is deeper somewhere than it may be

// A program that draws keeps its thread: then a worker paints. A graphics card works beside the page.
const paints = () => (isSoftware() && canPaintFar() ? FarPainting : undefined);

export class Picture {
  // place: the element that the picture takes; say: is told why there is none; opened: is given
  // the panel of each new picture.
  constructor(place, say, opened) {
    Object.assign(this, { place, say, opened, panel: null, answer: null, fetched: 0, figures: "" });
    matchMedia("(prefers-color-scheme: dark)").onchange = (event) => this.panel?.viewer.theme(event.matches);
  }

  // Fetch what stands still: the place, and the people at their sizes.
  async open() {
    const mine = ++this.fetched;
    try {
      const reply = await fetch("/scene");
      if (!reply.ok) throw new Error(await reply.text());
      const page = await readPage(await reply.text());
      if (mine !== this.fetched) return; // another study has been opened since
      this.replace(sceneOf(page, 0));
      if (this.answer) this.show(this.answer);
    } catch (error) {
      this.say(`no picture: ${error.message}`);
      this.place.querySelector(".still").textContent = `There is no picture: ${error.message}. All else can be used.`;
    }
  }

  // Show another scene, seen as the one before was seen; its panel.
  replace(scene) {
    this.fetched += 1; // what is on its way comes too late
    this.panel?.leave();
    const before = this.panel?.viewer;
    this.panel?.end();
    this.panel = null;
    this.panel = new Panel(this.place, scene, matchMedia("(prefers-color-scheme: dark)").matches, paints());
    if (before) this.panel.resume(before);
    this.opened(this.panel);
    return this.panel;
  }

  // Put people and seats where an answer has them; red is what is deeper than it may be.
  show(answer) {
    this.answer = answer;
    const set = answer.head.adjustments.map((one) => one.at);
    const figures = [...answer.head.people.map((one) => one.figure), ...set].join();
    if (this.figures && this.figures !== figures) this.open(); // another body, or a wheel set elsewhere
    this.figures = figures;
    if (!this.panel || this.panel.film) return;
    const { scene, viewer } = this.panel;
    answer.head.people.forEach((person, k) => {
      const body = scene.bodies[k];
      if (answer.arrays[`centres${k}`].length !== 3 * body.radius.length) return; // it is being fetched
      body.centres = body.frames = answer.arrays[`centres${k}`];
      const sphere = answer.arrays[`sphere${k}`];
      const room = answer.arrays[`room${k}`];
      const deep = sphere.filter((s, n) => room[n] < TOUCHES && s >= 0);
      body.tint = coloured(body, [...deep, ...answer.arrays[`overlap${k}`]]); // in a part, in somebody else
    });
    for (const part of scene.place?.parts ?? []) part.shift = answer.head.shifts[part.name] ?? null;
    scene.frame += 1; // another one for each answer: the card takes it up
    viewer.moving = true;
    viewer.partsChanged();
  }

  lookAt(point, words) {
    this.panel?.lookAt(point);
    this.panel?.say(words);
  }
}
