// The texts over a picture: distances, numbers of findings, and a ring around what is looked at.

import { vec } from "./camera.js";
import { element } from "./list.js";
import { isOf, stateAt } from "./wipe.js";

export class Labels {
  constructor({ scene, viewer, over }) {
    Object.assign(this, { scene, viewer });
    this.aim = null;
    this.ring = element("span", { className: "ring", hidden: true });
    this.texts = scene.marks.map((mark) => {
      const kind = `${mark.failing ? "bad" : ""}${mark.to ? "" : " point"}`;
      return element("span", { className: kind, textContent: mark.text, hidden: true });
    });
    over.append(...this.texts, this.ring);
  }

  // Marks of a motion are there while they last; none is where the section has cut all away.
  there() {
    const time = this.scene.times ? this.scene.times[this.scene.frame] : 0;
    const plane = this.viewer.section;
    return this.scene.marks.map(({ span, from }) => {
      if (plane && vec.dot(plane, from) + plane[3] > 0) return false;
      return !span || (time >= span[0] && time <= span[1]);
    });
  }

  // Put every text where its mark is seen, above those that would cover it.
  place() {
    const { clientWidth: width, clientHeight: height } = this.viewer.canvas;
    const seen = (point) => {
      const at = point && this.viewer.camera.project(point);
      return at && [(0.5 + 0.5 * at[0]) * width, (0.5 - 0.5 * at[1]) * height];
    };
    const put = (label, at) => {
      label.hidden = !at;
      if (at) Object.assign(label.style, { left: `${at[0]}px`, top: `${at[1]}px` });
    };
    const there = this.there();
    const taken = [];
    this.scene.marks.forEach((mark, k) => {
      const middle = mark.to ? vec.mul(vec.add(mark.from, mark.to), 0.5) : mark.from;
      const at = there[k] && mark.text ? seen(middle) : null;
      if (!at || !isOf(mark, stateAt(this.viewer.wipe, at[0] / width))) return put(this.texts[k], null);
      const wide = 4 * mark.text.length + 10;
      const x = Math.max(wide, Math.min(width - wide, at[0]));
      let y = at[1] - (mark.to ? 16 : 0);
      while (taken.some((one) => Math.abs(one.x - x) < one.wide + wide && Math.abs(one.y - y) < 22)) y -= 4;
      taken.push({ x, y, wide });
      return put(this.texts[k], [x, y]);
    });
    put(this.ring, seen(this.aim));
  }
}
