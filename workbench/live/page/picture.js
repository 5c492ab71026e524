// The picture of the bench: the viewer of the reports, moved by the answers.

import { Panel } from "/view/panel.js";
import { readPage, sceneOf } from "/view/wire.js";

const RED = [222, 36, 30];
const TOUCHES = -1e-6; // room [m] below which a sphere is deeper somewhere than it may be

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
      const before = this.panel?.viewer;
      this.panel?.end();
      this.panel = null;
      this.panel = new Panel(this.place, sceneOf(page, 0), matchMedia("(prefers-color-scheme: dark)").matches);
      if (before) this.resume(before);
      this.opened(this.panel);
      if (this.answer) this.show(this.answer);
    } catch (error) {
      this.say(`no picture: ${error.message}`);
    }
  }

  // Look as another viewer did.
  resume({ camera, section, walls, hiddenBodies, hiddenParts }) {
    const { viewer } = this.panel;
    Object.assign(viewer.camera, camera);
    Object.assign(viewer, { section, walls, hiddenBodies, hiddenParts });
    this.panel.sectionButton.setAttribute("aria-pressed", Boolean(section));
    this.panel.wallButton?.setAttribute("aria-pressed", !walls);
  }

  // Put people and seats where an answer has them; red is what is deeper than it may be.
  show(answer) {
    this.answer = answer;
    const figures = answer.head.people.map((one) => one.figure).join();
    if (this.figures && this.figures !== figures) this.open(); // somebody has another body
    this.figures = figures;
    if (!this.panel) return;
    const { scene, viewer } = this.panel;
    answer.head.people.forEach((person, k) => {
      const body = scene.bodies[k];
      if (answer.arrays[`centres${k}`].length !== 3 * body.radius.length) return; // it is being fetched
      body.centres = body.frames = answer.arrays[`centres${k}`];
      const tint = new Uint8Array(4 * body.radius.length);
      for (let s = 0; s < body.radius.length; s++) tint.set([...body.colour, 255], 4 * s);
      const sphere = answer.arrays[`sphere${k}`];
      answer.arrays[`room${k}`].forEach((room, n) => {
        if (room < TOUCHES && sphere[n] >= 0) tint.set([...RED, 255], 4 * sphere[n]);
      });
      for (const s of answer.arrays[`overlap${k}`]) tint.set([...RED, 255], 4 * s); // in somebody else
      body.tint = tint;
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
