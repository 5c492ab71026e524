// The arithmetic of turnable pictures: camera, picking and unpacking, by Node's own test runner.
import assert from "node:assert/strict";
import { test } from "node:test";

const at = process.env.WEB_MODULES;
const { Camera, VIEWS, vec } = await import(`${at}/camera.js`);
const { clearest, named, pick } = await import(`${at}/pick.js`);
const { boundsOf, decode, sceneOf, setFrame, unpack } = await import(`${at}/wire.js`);

const near = (a, b, least = 1e-9) => a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < least, `${a} ${b}`));
const all = { body: () => true, part: () => true };
const body = {
  name: "anna",
  radius: Float32Array.of(0.5, 0.25),
  centres: Float32Array.of(0, 0, 0, 0, 2, 0),
  frames: Float32Array.of(0, 0, 0, 0, 2, 0),
  segment: [0, 1],
  segments: ["hand", "foot"],
  spheres: ["", "big_toe"],
  failing: [],
  touching: [],
  colour: [1, 2, 3],
};
const place = {
  parts: [{ name: "left_wall" }, { name: "pane", glass: true }],
  part: [0, 0, 0, 0],
  vertices: Float32Array.of(1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1),
  triangles: Uint32Array.of(0, 1, 2, 0, 2, 3),
};
const scene = { bodies: [body], place, times: null };

test("a ray through where a point is seen goes through the point", () => {
  const camera = new Camera();
  Object.assign(camera, { at: [0.2, -0.1, 0.4], far: 2.5, azimuth: 1.1, height: 0.6, aspect: 1.7 });
  const point = [0.5, 0.3, 0.1];
  const [u, v] = camera.project(point);
  const { from, way } = camera.ray(u, v);
  const along = vec.dot(vec.sub(point, from), way);
  near(vec.add(from, vec.mul(way, along)), point);
});

test("the matrices put a point where project says", () => {
  const camera = new Camera();
  Object.assign(camera, { far: 2, azimuth: -0.4, height: 0.2, aspect: 1.3 });
  const { view, proj } = camera.matrices();
  const times = (m, p) => [0, 1, 2, 3].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r] * p[3]);
  const clip = times(proj, times(view, [0.1, 0.2, 0.3, 1]));
  near([clip[0] / clip[3], clip[1] / clip[3]], camera.project([0.1, 0.2, 0.3]));
});

test("a box that is fitted lies inside the picture and reaches near its edge from each view", () => {
  for (const [azimuth, height] of Object.values(VIEWS)) {
    const camera = new Camera();
    camera.aspect = 1.5;
    camera.look(azimuth, height);
    camera.fit([[-1, -0.5, 0], [1, 0.5, 1.2]]);
    const seen = [];
    for (const x of [-1, 1]) for (const y of [-0.5, 0.5]) for (const z of [0, 1.2]) seen.push(camera.project([x, y, z]));
    const most = Math.max(...seen.flat().map(Math.abs));
    assert.ok(most <= 1 && most > 0.9, `${most}`);
  }
});

test("left is from +y, front from +x, and the axes are right-handed and upright", () => {
  const camera = new Camera();
  camera.look(...VIEWS.left);
  near(vec.unit(camera.eye()), [0, 1, 0]);
  camera.look(...VIEWS.front);
  const { x, y, z } = camera.axes();
  near(vec.cross(x, y), z);
  near(y, [0, 0, 1]);
});

test("a ray finds the nearest thing, at its distance, with its name", () => {
  const hit = pick(scene, { from: [3, 0, 0], way: [-1, 0, 0] }, all, null);
  assert.equal(named(scene, hit), "left wall");
  near(hit.point, [1, 0, 0]);
  const other = pick(scene, { from: [3, 0, 0], way: [-1, 0, 0] }, { ...all, part: () => false }, null);
  assert.equal(named(scene, other), "anna: hand");
  near(other.point, [0.5, 0, 0]);
  const toe = pick(scene, { from: [0, 4, 0], way: [0, -1, 0] }, all, null);
  assert.equal(named(scene, toe), "anna: foot, big toe");
  assert.equal(pick(scene, { from: [3, 0, 5], way: [-1, 0, 0] }, all, null), null);
});

test("a section lets the ray into what is behind it", () => {
  const hit = pick(scene, { from: [3, 0, 0], way: [-1, 0, 0] }, all, [1, 0, 0, -0.9]);
  assert.equal(hit.kind, "body");
  const cut = pick(scene, { from: [3, 0, 0], way: [-1, 0, 0] }, all, [1, 0, 0, -0.2]);
  near([cut.point[0]], [-0.5]);
});

test("a place behind a wall is looked at from where no wall is", () => {
  const camera = new Camera();
  camera.look(0, 0);
  const seen = clearest(scene, camera, [0.5, 0, 0], all, null);
  assert.ok(seen.hidden < 0.03 || Math.abs(seen.azimuth) > 0.5, JSON.stringify(seen));
});

test("bytes, differences and steps are undone", () => {
  const low = [1, 255, 2];
  const high = [0, 255, 0]; // 1, -1, 2 as differences: 1, 0, 2
  const entry = { kind: "i2", count: 3, at: 1, stride: 1, step: 0.5, origin: [10] };
  near([...decode(Uint8Array.of(9, ...low, ...high), entry)], [10.5, 10, 11]);
  assert.deepEqual([...decode(Uint8Array.of(5, 1, 2), { kind: "u1", count: 3, at: 0, stride: 1 })], [5, 6, 8]);
});

test("frames are taken in turn, the last one held, and red only while something is touched", () => {
  const moving = { ...body, frames: Float32Array.of(0, 0, 0, 0, 2, 0, 1, 0, 0, 1, 2, 0), touching: [[1, 5, 20]] };
  const film = { bodies: [moving, body], times: [0, 10], place: null };
  setFrame(film, 1);
  assert.deepEqual([...film.bodies[0].centres.slice(0, 3)], [1, 0, 0]);
  assert.deepEqual([...film.bodies[1].centres.slice(0, 3)], [0, 0, 0]);
  assert.deepEqual([...film.bodies[0].tint.slice(4, 7)], [222, 36, 30]);
  setFrame(film, 0);
  assert.deepEqual([...film.bodies[0].tint.slice(4, 7)], [1, 2, 3]);
  near(boundsOf(film)[1], [1.5, 2.25, 0.5], 1e-6);
});

test("a block from Python opens to the numbers that went in", async () => {
  const { readFile } = await import("node:fs/promises");
  const { inflateRawSync } = await import("node:zlib");
  const packed = inflateRawSync(await readFile(process.env.WEB_BLOCK));
  const bytes = packed.buffer.slice(packed.byteOffset, packed.byteOffset + packed.length);
  const { header, array } = unpack(bytes);
  const made = sceneOf({ views: header.views, array }, 0);
  process.stdout.write(""); // the numbers go to Python, which knows what they should be
  const { writeFile } = await import("node:fs/promises");
  const plain = {
    centres: [...made.bodies[0].frames],
    radius: [...made.bodies[0].radius],
    vertices: [...made.place.vertices],
    triangles: [...made.place.triangles],
    edges: [...made.place.edges],
    part: [...made.place.part],
    names: made.place.parts.map((part) => part.name),
  };
  await writeFile(process.env.WEB_NUMBERS, JSON.stringify(plain));
});
