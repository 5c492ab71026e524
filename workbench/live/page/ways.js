// Where a pointer drags a point of the space to: plain arithmetic, no page.

import { vec } from "/view/camera.js";

// How far along an axis from a point [m] a ray passes nearest to it; null where it looks along the axis.
export function alongAxis(at, axis, ray) {
  const across = vec.dot(axis, ray.way);
  const square = 1 - across * across;
  if (square < 1e-4) return null;
  const away = vec.sub(at, ray.from);
  return (across * vec.dot(away, ray.way) - vec.dot(away, axis)) / square;
}

// Where a ray meets the plane through a point that is square to a direction; null behind the eye.
export function inPlane(at, normal, ray) {
  const toward = vec.dot(ray.way, normal);
  if (Math.abs(toward) < 1e-6) return null;
  const far = vec.dot(vec.sub(at, ray.from), normal) / toward;
  return far > 0 ? vec.add(ray.from, vec.mul(ray.way, far)) : null;
}

// The distance of a point of the picture from a line between two others, in their unit.
export function fromLine([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const size = dx * dx + dy * dy;
  const share = size ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / size)) : 0;
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

// Which handle a pointer is at: the index of an arrow, "free" in the middle, null at none.
export function handleAt(pointer, middle, tips, reach) {
  if (!middle) return null;
  if (Math.hypot(pointer[0] - middle[0], pointer[1] - middle[1]) < reach) return "free";
  let best = null;
  tips.forEach((tip, k) => {
    const far = tip ? fromLine(pointer, middle, tip) : Infinity;
    if (far < reach && (!best || far < best.far)) best = { far, k };
  });
  return best ? best.k : null;
}
