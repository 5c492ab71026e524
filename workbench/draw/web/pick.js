// What a ray meets first: a sphere of a body or a triangle of a part. Plain arithmetic, no GL.

import { vec } from "./camera.js";

const STILL = [0, 0, 0];

// What is seen under a ray, or null: the nearest thing that is solid; a see-through part only where
// nothing solid is behind it. `shown` says which parts and bodies count; `section` is a plane
// [a, b, c, d] beyond which (a x + b y + c z + d > 0) nothing is there; `veiled` says that parts which
// stand before a body are see-through. `before` of a hit is the nearest part that it is seen through.
export function pick(scene, ray, shown, section, veiled = false) {
  const body = nearestSphere(scene.bodies, ray, shown, section);
  const { solid, glass } = nearestFaces(scene.place, ray, shown, section);
  const hit = (veiled && body) || nearer(body, solid) || glass;
  if (!hit) return null;
  const front = nearer(solid, glass);
  for (const each of [hit, front]) {
    if (each) each.point = vec.add(ray.from, vec.mul(ray.way, each.far));
  }
  return { ...hit, before: front && front.far < hit.far ? front : null };
}

const nearer = (one, other) => (one && other ? (other.far < one.far ? other : one) : one || other);

// Whether two hits, either of which may be null, are of the same thing.
export function same(one, other) {
  if (!one || !other) return one === other;
  return ["kind", "body", "sphere", "part"].every((key) => one[key] === other[key]);
}

function beyond(section, ray, far) {
  if (!section) return false;
  const p = vec.add(ray.from, vec.mul(ray.way, far));
  return vec.dot(section, p) + section[3] > 0;
}

function nearestSphere(bodies, ray, shown, section) {
  const [ox, oy, oz] = ray.from;
  const [wx, wy, wz] = ray.way;
  let found = null;
  bodies.forEach((body, b) => {
    if (!shown.body(b)) return;
    const { centres, radius, tint } = body;
    for (let s = 0; s < radius.length; s++) {
      if (tint && !tint[4 * s + 3]) continue; // unseen
      const x = centres[3 * s] - ox;
      const y = centres[3 * s + 1] - oy;
      const z = centres[3 * s + 2] - oz;
      const along = x * wx + y * wy + z * wz;
      const under = along * along - (x * x + y * y + z * z) + radius[s] * radius[s];
      if (under < 0) continue;
      const root = Math.sqrt(under);
      let far = along - root;
      if (far < 0 || beyond(section, ray, far)) far = along + root;
      if (far < 0 || (found && far >= found.far) || beyond(section, ray, far)) continue;
      found = { kind: "body", body: b, sphere: s, far };
    }
  });
  return found;
}

// The nearest face of a part that is solid, and of one that is see-through; null where there is none.
function nearestFaces(place, ray, shown, section) {
  const found = { solid: null, glass: null };
  if (!place) return found;
  const { vertices: v, triangles: t, part } = place;
  const [wx, wy, wz] = ray.way;
  for (let i = 0; i < t.length; i += 3) {
    if (!shown.part(part[t[i]])) continue;
    // Moeller and Trumbore (1997), both sides
    const a = 3 * t[i];
    const b = 3 * t[i + 1];
    const c = 3 * t[i + 2];
    const [mx, my, mz] = place.parts[part[t[i]]].shift || STILL; // a part that was moved
    const e1 = [v[b] - v[a], v[b + 1] - v[a + 1], v[b + 2] - v[a + 2]];
    const e2 = [v[c] - v[a], v[c + 1] - v[a + 1], v[c + 2] - v[a + 2]];
    const px = wy * e2[2] - wz * e2[1];
    const py = wz * e2[0] - wx * e2[2];
    const pz = wx * e2[1] - wy * e2[0];
    const det = e1[0] * px + e1[1] * py + e1[2] * pz;
    if (Math.abs(det) < 1e-12) continue;
    const sx = ray.from[0] - mx - v[a];
    const sy = ray.from[1] - my - v[a + 1];
    const sz = ray.from[2] - mz - v[a + 2];
    const u = (sx * px + sy * py + sz * pz) / det;
    if (u < 0 || u > 1) continue;
    const qx = sy * e1[2] - sz * e1[1];
    const qy = sz * e1[0] - sx * e1[2];
    const qz = sx * e1[1] - sy * e1[0];
    const w = (wx * qx + wy * qy + wz * qz) / det;
    if (w < 0 || u + w > 1) continue;
    const far = (e2[0] * qx + e2[1] * qy + e2[2] * qz) / det;
    const kind = place.parts[part[t[i]]].glass ? "glass" : "solid";
    if (far <= 1e-6 || (found[kind] && far >= found[kind].far) || beyond(section, ray, far)) continue;
    found[kind] = { kind: "part", part: part[t[i]], far };
  }
  return found;
}

// What a hit is called: "pilot: right hand, thumb tip", or the name of a part.
export function named(scene, hit) {
  if (hit.kind === "part") return plain(scene.place.parts[hit.part].name);
  const body = scene.bodies[hit.body];
  const segment = body.segments[body.segment[hit.sphere]];
  const sphere = body.spheres[hit.sphere];
  if (body.segments.length === 1 && body.name.endsWith(segment)) return body.name; // a belt
  return `${body.name}: ${sphere ? `${segment}, ${plain(sphere)}` : segment}`;
}

export const plain = (name) => name.replaceAll("_", " ");

// From where a point is seen best: the azimuth and height of those tried from which least stands
// before it; of equals the one nearest to how the camera looks now.
export function clearest(scene, camera, point, shown, section) {
  let best = null;
  for (const height of [0.35, 0.05, 0.9]) {
    for (let k = 0; k < 8; k++) {
      const azimuth = camera.azimuth + ((k % 2 ? 1 : -1) * Math.ceil(k / 2) * Math.PI) / 4;
      const c = Math.cos(height);
      const way = [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(height)];
      const ray = { from: vec.add(point, vec.mul(way, 3)), way: vec.mul(way, -1) };
      const hit = pick(scene, ray, shown, section);
      const hidden = Math.max(0, (hit ? 3 - hit.far : 0) - 0.03);
      if (!best || hidden < best.hidden - 1e-9) best = { azimuth, height, hidden };
      if (best.hidden === 0) return best;
    }
  }
  return best;
}
