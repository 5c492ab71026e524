// Units of the scripts of pages. tests/test_page_scripts.py runs them in a folder with `view` (draw/web),
// `page` (live/page) and an answer that Python has packed.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { Camera, vec } from "./view/camera.js";
import { clearest, named, pick } from "./view/pick.js";
import { boundsOf, decode, unpack } from "./view/wire.js";
import { rangesOf } from "./page/grips.js";
import { change, who } from "./page/people.js";
import { rowsOf, wanted } from "./page/size.js";
import { alongAxis, fromLine, handleAt, inPlane } from "./page/ways.js";

const near = (a, b, by = 1e-9) =>
  a.forEach((value, k) => assert.ok(Math.abs(value - b[k]) < by, `${a} is not ${b}`));

test("arrays come out as Python has packed them", () => {
  const bytes = readFileSync(new URL("./answer.bin", import.meta.url));
  const { header, array } = unpack(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  assert.equal(header.kind, "answer – ß");
  assert.deepEqual([...array(0)], [0.5, -1.25, 4096]);
  assert.deepEqual([...array(1)], [0, 65535, 258]);
  assert.deepEqual([...array(2)], [-1, 70000]);
  assert.equal(array(0), array(0));
});

test("differences and steps are undone", () => {
  const entry = { kind: "i2", count: 4, at: 0, stride: 2, step: 0.5, origin: [10, 20] };
  const bytes = Uint8Array.from([1, 2, 1, 255, 0, 0, 0, 255]); // 1, 2, +1, -1: low bytes, high bytes
  assert.deepEqual([...decode(bytes, entry)], [10.5, 21, 11, 20.5]);
});

test("what a ray passes through is seen where the ray began", () => {
  const camera = new Camera();
  Object.assign(camera, { at: [1, 2, 3], far: 4, azimuth: 0.3, height: -0.6, aspect: 1.7 });
  for (const [u, v] of [[0, 0], [0.4, -0.7], [-1, 1]]) {
    const ray = camera.ray(u, v);
    near(camera.project(vec.add(ray.from, vec.mul(ray.way, 2.5))), [u, v]);
  }
  assert.equal(camera.project(vec.add(camera.eye(), camera.axes().z)), null);
});

test("a box that fits is seen whole", () => {
  const camera = new Camera();
  camera.fit([[-1, -2, 0], [3, 1, 1.5]]);
  for (const corner of [[-1, -2, 0], [3, 1, 1.5], [-1, 1, 1.5], [3, -2, 0]]) {
    assert.ok(camera.project(corner).every((value) => Math.abs(value) <= 1));
  }
});

const SCENE = {
  bodies: [
    { name: "pilot", centres: [0, 0, 0, 0, 0, 1], radius: [0.2, 0.1], segment: [0, 1], segments: ["hand", "arm"], spheres: ["thumb_tip", ""] },
  ],
  place: {
    parts: [{ name: "side_wall", shift: [0.5, 0, 0] }],
    vertices: [0, -1, -1, 0, 1, -1, 0, 0, 1],
    part: [0, 0, 0],
    triangles: [0, 1, 2],
  },
};
const ALL = { body: () => true, part: () => true };

test("a ray meets what is nearest, parts where they were moved to", () => {
  const ray = { from: [3, 0, 0], way: [-1, 0, 0] };
  const wall = pick(SCENE, ray, ALL, null);
  assert.equal(wall.kind, "part");
  near(wall.point, [0.5, 0, 0]);
  assert.equal(named(SCENE, wall), "side wall");
  const body = pick(SCENE, ray, { ...ALL, part: () => false }, null);
  near(body.point, [0.2, 0, 0]);
  assert.equal(named(SCENE, body), "pilot: hand, thumb tip");
  const cut = pick(SCENE, ray, { ...ALL, part: () => false }, [1, 0, 0, 0]); // x > 0 is cut away
  near(cut.point, [-0.2, 0, 0]);
  assert.equal(pick(SCENE, { from: [3, 0, 5], way: [-1, 0, 0] }, ALL, null), null);
  assert.equal(clearest(SCENE, new Camera(), [0, 0, 1.2], ALL, null).hidden, 0);
  near(boundsOf(SCENE && { bodies: [{ ...SCENE.bodies[0], frames: SCENE.bodies[0].centres }] }).flat(), [-0.2, -0.2, -0.2, 0.2, 0.2, 1.1]);
});

test("a pointer drags along an arrow and in a plane", () => {
  const ray = { from: [2, 5, 1], way: [0, -1, 0] };
  assert.equal(alongAxis([0, 0, 1], [1, 0, 0], ray), 2);
  assert.equal(alongAxis([0, 0, 1], [0, 1, 0], ray), null);
  near(inPlane([0, 0, 0], [0, 1, 0], ray), [2, 0, 1]);
  assert.equal(inPlane([0, 9, 0], [0, 1, 0], ray), null);
  assert.equal(inPlane([0, 0, 0], [1, 0, 0], ray), null);
  assert.equal(fromLine([1, 2], [0, 0], [4, 0]), 2);
  assert.equal(fromLine([-3, 4], [0, 0], [4, 0]), 5);
  assert.equal(fromLine([3, 4], [0, 0], [0, 0]), 5);
});

test("the handle under a pointer is the middle, the nearest arrow or none", () => {
  const tips = [[100, 0], [0, 100], null];
  assert.equal(handleAt([3, 3], [0, 0], tips, 10), "free");
  assert.equal(handleAt([60, 4], [0, 0], tips, 10), 0);
  assert.equal(handleAt([6, 60], [0, 0], tips, 10), 1);
  assert.equal(handleAt([60, 60], [0, 0], tips, 10), null);
  assert.equal(handleAt([3, 3], null, tips, 10), null);
});

test("people and changes of shares are put into words", () => {
  assert.equal(who({ person: 3, sex: "female", stature: 1602 }), "person 3, a woman of 1602 mm");
  assert.equal(who({ person: 4, sex: "male", stature: null }), "person 4, a man");
  assert.equal(change(0.5, 0.62), "−12.0");
  assert.equal(change(0.62, 0.5), "+12.0");
  assert.equal(change(0.5, 0.5004), "");
});

test("a size is asked for by measures, and by the percentile that was changed alone", () => {
  const fields = {
    stature: { value: "1600", percentile: "30.1" },
    sitting_height: { value: "", percentile: "" },
    mass: { value: "61.5", percentile: "44.0" },
  };
  const form = { sex: "female", age: "", fields };
  assert.deepEqual(wanted(form), { sex: "female", measures: { stature: 1.6 }, percentiles: {}, mass: 61.5 });
  assert.deepEqual(wanted(form, "stature"), { sex: "female", measures: {}, percentiles: { stature: 30.1 }, mass: 61.5 });
  assert.deepEqual(wanted({ sex: "male", age: "", fields: {} }).percentiles, { stature: 50 });
  assert.deepEqual(wanted({ sex: "male", age: "6", fields: {} }), { sex: "male", age: 6, measures: {}, percentiles: {} });
  assert.deepEqual(wanted({ ...form, sex: "" }), {});
  assert.deepEqual(rowsOf({ measures: { hand_length: [0.2, 50] } }), ["stature", "sitting_height", "mass", "hand_length"]);
});

test("the spheres of a limb are runs of indices", () => {
  assert.deepEqual(rangesOf([0, 0, 1, 2, 2, 1], (k) => k !== 1), [[0, 2], [3, 5]]);
  assert.deepEqual(rangesOf([1, 1], () => false), []);
});
