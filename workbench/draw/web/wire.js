// From the bytes of a page to the arrays of a picture; see packing.py for how they are laid out.

const KINDS = {
  f4: Float32Array,
  f8: Float64Array,
  i2: Int16Array,
  i4: Int32Array,
  u1: Uint8Array,
  u2: Uint16Array,
  u4: Uint32Array,
};

// The block of a page: base64 text of deflated bytes -> { views, array(index) }.
export async function readPage(text) {
  return readBlock(Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0)));
}

// The same of the deflated bytes.
export async function readBlock(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const { header, array } = unpack(await new Response(stream).arrayBuffer());
  return { views: header.views, array };
}

// Four bytes: the length of the JSON header; the header; then the arrays one after the other. Gives
// the header, and the array of an index.
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const bytes = new Uint8Array(buffer);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  let start = 4 + length;
  const entries = header.arrays.map((entry) => {
    const at = start;
    start += entry.count * KINDS[entry.kind].BYTES_PER_ELEMENT;
    return { ...entry, at };
  });
  const kept = new Map();
  const array = (index) => {
    if (!kept.has(index)) kept.set(index, decode(bytes, entries[index]));
    return kept.get(index);
  };
  return { header, array };
}

// Undo what packing did: bytes by place in the number, differences, steps from an origin.
export function decode(bytes, { kind, count, at, stride, step, origin }) {
  const Kind = KINDS[kind];
  const width = Kind.BYTES_PER_ELEMENT;
  const raw = new Uint8Array(count * width);
  for (let w = 0; w < width; w++) {
    for (let i = 0; i < count; i++) raw[i * width + w] = bytes[at + w * count + i];
  }
  const whole = new Kind(raw.buffer);
  if (stride) for (let i = stride; i < count; i++) whole[i] += whole[i - stride];
  if (!step) return whole;
  const values = new Float32Array(count);
  const n = origin.length;
  for (let i = 0; i < count; i++) values[i] = origin[i % n] + whole[i] * step;
  return values;
}

// The scene of one view: arrays in the place of their indices.
export function sceneOf(page, index) {
  const view = page.views[index];
  const place = view.place && {
    parts: view.place.parts,
    vertices: page.array(view.place.vertices),
    part: page.array(view.place.part),
    triangles: Uint32Array.from(page.array(view.place.triangles)),
    edges: Uint32Array.from(page.array(view.place.edges)),
  };
  const bodies = view.bodies.map((body) => {
    const radius = page.array(body.radius);
    const frames = page.array(body.centres);
    const segment = page.array(body.segment);
    const spheres = new Array(radius.length).fill("");
    for (const [sphere, name] of body.spheres) spheres[sphere] = name;
    const centres = frames.subarray(0, 3 * radius.length);
    const made = { ...body, radius, frames, segment, spheres, centres };
    return { ...made, tint: tintOf(made, 0) };
  });
  const gaps = view.gaps && { ...view.gaps, least: page.array(view.gaps.least) };
  if (gaps?.asked !== undefined) gaps.asked = page.array(gaps.asked);
  return { ...view, place, bodies, gaps };
}

const RED = [222, 36, 30];

// The colours of the spheres of a body: some are red, and the segment `body.unseen` is not drawn.
export function coloured(body, red) {
  const count = body.radius.length;
  const tint = new Uint8Array(4 * count);
  for (let s = 0; s < count; s++) tint.set([...body.colour, 255], 4 * s);
  for (const s of red) tint.set([...RED, 255], 4 * s);
  for (let s = 0; s < count; s++) if (body.segment[s] === body.unseen) tint[4 * s + 3] = 0;
  return tint;
}

// The colours at a time [ms]: red where a body fails, or touches just then.
function tintOf(body, time) {
  const now = body.touching.filter(([, from, to]) => time >= from && time <= to);
  return coloured(body, [...body.failing, ...now.map(([s]) => s)]);
}

// Put all bodies into a frame of a motion; `scene.first` is the frame that their frames begin with.
export function setFrame(scene, frame) {
  for (const body of scene.bodies) {
    const size = 3 * body.radius.length;
    const held = Math.min(frame - (scene.first ?? 0), body.frames.length / size - 1);
    body.centres = body.frames.subarray(held * size, (held + 1) * size);
    if (scene.times) body.tint = tintOf(body, scene.times[frame]);
  }
  scene.frame = frame;
}

// The box [low, high] of all bodies that are no ghosts, in all frames; of the place without bodies.
export function boundsOf(scene) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const take = (points, radius) => {
    for (let i = 0; i < points.length; i++) {
      const r = radius ? radius[Math.floor(i / 3) % radius.length] : 0;
      low[i % 3] = Math.min(low[i % 3], points[i] - r);
      high[i % 3] = Math.max(high[i % 3], points[i] + r);
    }
  };
  const bodies = scene.bodies.filter((body) => !body.ghost);
  for (const body of bodies) take(body.frames, body.radius);
  if (!bodies.length && scene.place) take(scene.place.vertices, null);
  return [low, high];
}
