// Ways of looking at what the bench shows: motions, from an eye, distances, reach envelopes, the saved state.

import { ask } from "./connection.js";
import { at } from "./elements.js";
import { Copying } from "./copying.js";
import { Envelope } from "./envelope.js";
import { Eye } from "./eye.js";
import { Field } from "./field.js";
import { Filming } from "./filming.js";
import { Ghost } from "./ghost.js";
import { Measure } from "./measure.js";
import { Motion } from "./motion.js";

export class Looks {
  // state: hello, answer and the number of the person; picture: where all is shown; say: is told
  // what goes on.
  constructor(state, picture, say) {
    Object.assign(this, { state, picture });
    this.motion = state.motion = new Motion(picture, say, () => this.eye.follow());
    this.eye = new Eye(() => this.eyes(), () => this.repaint(), say);
    this.field = new Field(this.eye, state);
    this.measure = new Measure(say);
    this.envelope = new Envelope(() => this.hand(), say);
    this.copying = new Copying(() => this.names(), say);
    const motion = () => this.motion.name;
    this.filming = new Filming({ motion, eyes: () => this.eye.set?.role, names: () => this.names(), say });
    this.ghost = new Ghost(state, () => (this.motion.there ? this.motion.packed : null), say);
  }

  // Take the picture that is there now.
  attach(panel) {
    for (const one of [this.eye, this.measure, this.envelope, this.ghost, this.copying, this.filming]) one.attach(panel);
  }

  take(found) {
    const { head } = found;
    if (head.kind === "measured") this.measure.take(head);
    if (head.kind === "field") this.field.take(found);
    if (head.kind === "film") this.filming.take(head);
    if (head.kind === "fault" && head.where === "film") this.filming.forget();
    if (head.kind === "ghost") this.ghost.take(found);
    if (head.kind === "saved") this.ghost.forget();
    if (head.kind === "envelope") this.envelope.take(found, this.state.answer?.generation);
    if (["motion", "frames", "gaps"].includes(head.kind)) this.motion.take(found);
  }

  // A study was opened: show its picture, or its motion where it has nothing else.
  hello(head) {
    this.measure.build(head);
    this.eye.field = head.field;
    this.envelope.away();
    this.ghost.forget();
    if (head.motions.includes(this.motion.name) || !head.cases.length) return this.motion.reopen(head.motions);
    this.motion.close();
    return this.picture.open();
  }

  answered(found) {
    for (const one of [this.motion, this.measure, this.envelope]) one.answered(found.head);
    this.ghost.answered(found);
    this.eye.follow();
    this.field.answered(found.head);
  }

  // Look at a case; at a motion from a time [s] on.
  show(name, time = null) {
    at("case").value = name;
    if (this.state.hello.motions.includes(name)) return this.motion.open(name, time);
    if (this.motion.there) {
      this.motion.close();
      this.picture.open();
    }
    return ask("case", { name });
  }

  // Words that name what is shown: the study, the case, the time of a motion.
  names() {
    const { film } = this.picture.panel ?? {};
    const time = film && `${(film.times[film.frame] / 1000).toFixed(3)}s`;
    return [this.state.hello.file.replace(/\.ya?ml$/, ""), at("case").value, time];
  }

  get role() {
    return this.state.hello.people[this.state.person]?.role;
  }

  // Where the person who is chosen looks from.
  eyes() {
    if (this.motion.there) return this.motion.eyes(this.role);
    const found = this.state.answer?.people[this.state.person]?.eyes;
    return found && { ...found, role: this.role, body: this.state.person };
  }

  repaint() {
    const { panel, answer } = this.picture;
    if (panel?.film) panel.at(panel.film.frame);
    else if (answer) this.picture.show(answer);
    this.ghost.show();
  }

  hand() {
    return { person: this.role, limb: at("limb-name").value, obstacles: at("limb-obstacles").checked };
  }
}
