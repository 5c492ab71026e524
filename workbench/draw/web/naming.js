// How what is chosen, cut away and hidden in a picture is called outside of it, as in a notebook.

const DECIMALS = 4; // of the place of a section [m]
// Of each side the axis, and the sign of the coordinates on it: the side that a section takes away.
const SIDES = { front: [0, 1], back: [0, -1], left: [1, 1], right: [1, -1], top: [2, 1], bottom: [2, -1] };

export const isSame = (one, two) => JSON.stringify(one) === JSON.stringify(two);

// "left=0.3" or "left": axis, sign, and the place where one is named.
export function sectionOf(words) {
  const [side, at] = words.split("=");
  const [axis, sign] = SIDES[side];
  return { axis, sign, at: at === undefined ? undefined : Number(at) };
}

// A plane across an axis as "left=0.3".
export function sectionWords(plane) {
  const axis = plane.findIndex((value) => Math.abs(value) === 1);
  const side = Object.keys(SIDES).find((name) => SIDES[name][0] === axis && SIDES[name][1] === plane[axis]);
  return `${side}=${Number((-plane[3] * plane[axis]).toFixed(DECIMALS))}`;
}

// The names of what is chosen: of a part; of a person, the segment, and the sphere where it has a name.
export function namesOf(scene, chosen) {
  if (chosen.names) return chosen.names; // as they were given
  if (chosen.kind === "part") return [scene.place.parts[chosen.part].name];
  const body = scene.bodies[chosen.body];
  const sphere = body.spheres[chosen.sphere];
  return [body.name, body.segments[body.segment[chosen.sphere]], ...(sphere ? [sphere] : [])];
}

// What has such names, with a point of it; null where nothing has.
export function chosenOf(scene, names) {
  const [first, segment, sphere] = names;
  if (segment === undefined) {
    const part = scene.place ? scene.place.parts.findIndex(({ name }) => name === first) : -1;
    return part < 0 ? null : { kind: "part", part, names, point: centreOf(scene.place, part) };
  }
  const body = scene.bodies.findIndex(({ name }) => name === first);
  if (body < 0) return null;
  const { segments, spheres, segment: own } = scene.bodies[body];
  const fits = (k) => segments[own[k]] === segment && (sphere === undefined || spheres[k] === sphere);
  const inside = [...own.keys()].filter(fits);
  if (!inside.length) return null;
  const k = inside[inside.length >> 1];
  return { kind: "body", body, sphere: k, names, point: centreAt(scene.bodies[body], k) };
}

export const centreAt = ({ centres }, sphere) => [...centres.subarray(3 * sphere, 3 * sphere + 3)];

// The middle of the box around a part.
function centreOf({ vertices, part }, wanted) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  part.forEach((one, v) => {
    if (one !== wanted) return;
    for (let i = 0; i < 3; i++) {
      low[i] = Math.min(low[i], vertices[3 * v + i]);
      high[i] = Math.max(high[i], vertices[3 * v + i]);
    }
  });
  return low.map((value, i) => (value + high[i]) / 2);
}

// Whether people can be moved to where others are: as many, of the same names and numbers of spheres.
export function areAlike(people, others) {
  const same = (body, k) => body.name === others[k].name && body.radius.length === others[k].radius.length;
  return people.length === others.length && people.every(same);
}

// Whether what stands behind an element is dark: the first colour that is not see-through.
export function isDark(element) {
  const pen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  for (let one = element.parentNode; one; one = one.parentNode ?? one.host) {
    if (!(one instanceof Element)) continue;
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = getComputedStyle(one).backgroundColor; // rgb, oklch, ...: painted to be told
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b, opacity] = pen.getImageData(0, 0, 1, 1).data;
    if (opacity >= 128) return 0.299 * r + 0.587 * g + 0.114 * b < 128;
  }
  return matchMedia("(prefers-color-scheme: dark)").matches;
}
