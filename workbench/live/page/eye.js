// The view of a person: from between the eyes, along the gaze, without the person's own head.

const DEGREES = 180 / Math.PI;

// How wide a picture is seen [rad] that is seen so high [rad].
export const across = (high, aspect) => 2 * Math.atan(Math.tan(high / 2) * aspect);

// What is seen, in words.
export function fieldWords(role, high, aspect) {
  const [up, side] = [high, across(high, aspect)].map((angle) => Math.round(DEGREES * angle));
  return (
    `${role}'s view: the field is ${up}° high and ${side}° wide. Drag turns the gaze, + and - change the field, ` +
    "Esc or a view leaves."
  );
}

export class Eye {
  // source: gives where the person who is chosen looks from, { role, at, sight, up, head, body }, or
  // null; repaint: paints the people anew; say: is told why there is no view.
  constructor(source, repaint, say) {
    Object.assign(this, { source, repaint, say, panel: null, set: null, body: null, turned: null, veiled: false, field: 0, shown: () => {} });
    document.addEventListener("left", () => this.left());
  }

  // Take the picture that is there now.
  attach(panel) {
    this.panel = panel;
    this.set = this.body = this.turned = null;
    this.veiled = false;
    this.button = panel.button("eye", () => this.toggle(), false);
    panel.bar.querySelector(".space").before(this.button);
    panel.viewer.addEventListener("frame", () => this.tell());
  }

  toggle() {
    if (this.set) this.panel.leave();
    else if (!this.source()) this.say("this person has no eyes to look from", true);
    else this.look(this.field);
  }

  look(angle) {
    const from = this.source();
    const body = this.panel.scene.bodies[from?.body];
    if (!body) return;
    const { camera } = this.panel.viewer;
    if (!this.set && !this.panel.viewer.walls) {
      this.panel.setWalls(); // nobody sees through walls
      this.veiled = true;
    }
    const turned = this.set && [camera.azimuth - this.set.azimuth, camera.height - this.set.height];
    this.panel.stand(from, angle);
    this.set = { azimuth: camera.azimuth, height: camera.height, role: from.role };
    if (turned) camera.look(camera.azimuth + turned[0], camera.height + turned[1]);
    this.button.setAttribute("aria-pressed", "true");
    if (this.body === body && body.unseen === from.head) return;
    if (this.body) delete this.body.unseen;
    body.unseen = from.head;
    this.body = body;
    this.turned = null;
    this.repaint();
  }

  // Head and trunk turn with the gaze, with all that they bear: the eyes are at a point, the spheres about centres.
  turn(at, centres) {
    const { scene, viewer } = this.panel;
    if (!this.set || this.body.centres.length !== centres.length) return; // it is being fetched
    this.turned = [at, centres];
    if (this.body.centres === centres && viewer.camera.at === at) return;
    viewer.camera.at = at;
    this.body.centres = this.body.frames = centres;
    scene.frame += 1;
    viewer.moved();
  }

  // The people have moved: the view goes along, turned as it was, until it is known how they sit who look there.
  follow() {
    if (!this.set) return;
    this.look(this.panel.viewer.camera.angle);
    if (this.turned && !this.panel.film) this.turn(...this.turned);
  }

  left() {
    if (!this.set) return;
    this.set = null;
    if (this.body) delete this.body.unseen;
    this.body = this.turned = null;
    if (this.veiled && this.panel.viewer.walls) this.panel.setWalls();
    this.veiled = false;
    this.button.setAttribute("aria-pressed", "false");
    this.panel.say(this.panel.words);
    this.repaint();
    this.shown();
  }

  // Say the field once the picture has its size; shown: is called at each picture, and once the view is left.
  tell() {
    if (!this.set) return;
    const { angle, aspect } = this.panel.viewer.camera;
    const words = fieldWords(this.set.role, angle, aspect);
    if (this.panel.said.textContent !== words) this.panel.say(words);
    this.shown();
  }
}
