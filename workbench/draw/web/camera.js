// The camera of a turnable picture: it looks at a point from a distance, z up. No GL in here.

export const vec = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  mul: (a, k) => [a[0] * k, a[1] * k, a[2] * k],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ],
  unit: (a) => vec.mul(a, 1 / (Math.hypot(a[0], a[1], a[2]) || 1)),
};

// Azimuth and height [rad] of the eye; x is forward, y left, z up.
export const VIEWS = {
  left: [Math.PI / 2, 0],
  right: [-Math.PI / 2, 0],
  front: [0, 0],
  back: [Math.PI, 0],
  top: [Math.PI, 1.5],
  corner: [0.85, 0.45],
};

const MOST_HEIGHT = 1.5;
const NEAREST = 0.1;
const FARTHEST = 60;
const MARGIN = 1.04;
const AT_HAND = 1e-3; // m between an eye and the point that it looks about
const NARROW = 0.17; // rad that an eye sees at least and at most
const WIDE = 2.1;

export class Camera {
  constructor() {
    this.at = [0, 0, 0];
    this.far = 3;
    this.azimuth = VIEWS.corner[0];
    this.height = VIEWS.corner[1];
    this.angle = 0.5;
    this.aspect = 1;
    this.farthest = FARTHEST;
    this.roll = 0;
    this.orbit = null; // how it looked before it stood in an eye
  }

  // Look from an eye { at, sight, up } instead of about a point; `angle` [rad] is seen from bottom to top.
  stand({ at, sight, up }, angle = this.angle) {
    const { far, azimuth, height } = this;
    this.orbit ??= { at: this.at, far, azimuth, height, angle: this.angle };
    Object.assign(this, { at, far: AT_HAND, angle, roll: 0 });
    this.look(Math.atan2(-sight[1], -sight[0]), Math.asin(Math.max(-1, Math.min(1, -sight[2]))));
    const { x, y } = this.axes();
    this.roll = Math.atan2(-vec.dot(up, x), vec.dot(up, y));
  }

  // Look about a point again, as before; whether it stood in an eye.
  leave() {
    if (!this.orbit) return false;
    Object.assign(this, this.orbit, { orbit: null, roll: 0 });
    return true;
  }

  eye() {
    const c = Math.cos(this.height);
    const way = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.height)];
    return vec.add(this.at, vec.mul(way, this.far));
  }

  // x to the right, y up, z toward the viewer
  axes() {
    const eye = this.eye();
    const z = vec.unit(vec.sub(eye, this.at));
    const level = [-Math.sin(this.azimuth), Math.cos(this.azimuth), 0];
    const x = vec.add(vec.mul(level, Math.cos(this.roll)), vec.mul(vec.cross(z, level), Math.sin(this.roll)));
    return { eye, x, y: vec.cross(z, x), z };
  }

  // View and projection matrices, column by column as GL takes them.
  matrices() {
    const { eye, x, y, z } = this.axes();
    const f = 1 / Math.tan(this.angle / 2);
    const n = Math.max(0.02, this.far * 0.02);
    const e = this.far + Math.max(40, this.farthest - FARTHEST);
    const away = [-vec.dot(x, eye), -vec.dot(y, eye), -vec.dot(z, eye), 1];
    return {
      view: [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ...away],
      proj: [f / this.aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (e + n) / (n - e), -1, 0, 0, (2 * e * n) / (n - e), 0],
    };
  }

  // The ray through a place of the picture: u, v from -1 to 1, to the right and up.
  ray(u, v) {
    const { eye, x, y, z } = this.axes();
    const t = Math.tan(this.angle / 2);
    const across = vec.add(vec.mul(x, u * t * this.aspect), vec.mul(y, v * t));
    return { from: eye, way: vec.unit(vec.sub(across, z)) };
  }

  // Where a point is in the picture: u, v from -1 to 1; null behind the eye.
  project(point) {
    const { eye, x, y, z } = this.axes();
    const p = vec.sub(point, eye);
    const depth = -vec.dot(p, z);
    if (depth <= 1e-6) return null;
    const t = Math.tan(this.angle / 2);
    return [vec.dot(p, x) / (depth * t * this.aspect), vec.dot(p, y) / (depth * t)];
  }

  turn(azimuth, height) {
    const way = this.orbit ? -1 : 1; // an eye turns itself, not what it looks at
    this.azimuth = (this.azimuth + way * azimuth) % (2 * Math.PI);
    this.height = Math.max(-MOST_HEIGHT, Math.min(MOST_HEIGHT, this.height + way * height));
  }

  // Move across by shares of the picture's height, so that what is grasped stays under the hand.
  pan(right, up) {
    if (this.orbit) return;
    const { x, y } = this.axes();
    const size = 2 * this.far * Math.tan(this.angle / 2);
    this.at = vec.add(this.at, vec.add(vec.mul(x, -right * size), vec.mul(y, -up * size)));
  }

  zoom(factor) {
    if (this.orbit) this.angle = Math.max(NARROW, Math.min(WIDE, this.angle * factor));
    else this.far = Math.max(NEAREST, Math.min(this.farthest, this.far * factor));
  }

  look(azimuth, height) {
    this.azimuth = azimuth;
    this.height = height;
  }

  // Take the distance at which a box [low, high] just fills the picture, looking from here.
  fit([low, high]) {
    this.at = vec.mul(vec.add(low, high), 0.5);
    const { x, y, z } = this.axes();
    const t = Math.tan(this.angle / 2);
    let far = NEAREST;
    for (let k = 0; k < 8; k++) {
      const corner = [0, 1, 2].map((i) => ((k >> i) & 1 ? high[i] : low[i]));
      const p = vec.sub(corner, this.at);
      const toward = vec.dot(p, z);
      const across = Math.abs(vec.dot(p, x)) / (t * this.aspect);
      far = Math.max(far, toward + MARGIN * Math.max(across, Math.abs(vec.dot(p, y)) / t));
    }
    this.far = Math.min(this.farthest, far);
  }
}
