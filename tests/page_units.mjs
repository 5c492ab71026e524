// Units of the scripts of pages. tests/test_page_scripts.py runs them in a folder with `view` (draw/web),
// `page` (live/page) and an answer that Python has packed.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { Camera, vec } from "./view/camera.js";
import { clearest, named, pick, same } from "./view/pick.js";
import { areAlike, chosenOf, namesOf, sectionOf, sectionWords } from "./view/naming.js";
import { boundsOf, decode, unpack } from "./view/wire.js";
import { rangesOf } from "./page/grips.js";
import { frameAt, path, worstOf } from "./view/film.js";
import { coloured, setFrame } from "./view/wire.js";
import { isOf, stateAt, stripes, wipeWords } from "./view/wipe.js";
import { veilOf } from "./page/envelope.js";
import { broken, fileName } from "./page/copying.js";
import { across, fieldWords } from "./page/eye.js";
import { freeWords, gazeWords, turnWords } from "./page/field.js";
import { planeOf } from "./page/filming.js";
import { farthest, movedWords, shiftOf, veilOfParts } from "./page/ghost.js";
import { components, dimensionLines, thingOf } from "./page/measure.js";
import { nearestToFailing, startOf, surplus } from "./page/motion.js";
import { band, bands, ticks } from "./page/reach_map.js";
import { change, range, who } from "./page/people.js";
import { isOfElement } from "./page/keys.js";
import { stepWords } from "./page/progress.js";
import { allowedWords, marginWords, resultWords, signed } from "./page/rows.js";
import { rowsOf, wanted } from "./page/size.js";
import { summary } from "./page/verdicts.js";
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
  const belt = { name: "right shoulder belt", segments: ["belt"], segment: [0], spheres: [""] };
  assert.equal(named({ bodies: [belt] }, { kind: "body", body: 0, sphere: 0 }), "right shoulder belt");
  const cut = pick(SCENE, ray, { ...ALL, part: () => false }, [1, 0, 0, 0]); // x > 0 is cut away
  near(cut.point, [-0.2, 0, 0]);
  assert.equal(pick(SCENE, { from: [3, 0, 5], way: [-1, 0, 0] }, ALL, null), null);
  assert.equal(clearest(SCENE, new Camera(), [0, 0, 1.2], ALL, null).hidden, 0);
  near(boundsOf(SCENE && { bodies: [{ ...SCENE.bodies[0], frames: SCENE.bodies[0].centres }] }).flat(), [-0.2, -0.2, -0.2, 0.2, 0.2, 1.1]);
});

test("what is seen through a part is picked before it, and the part where nothing solid is behind", () => {
  const at = (x) => [x, -1, -1, x, 1, -1, x, 0, 1];
  const place = {
    parts: [{ name: "canopy", glass: true }, { name: "wall" }, { name: "lever" }],
    vertices: [...at(2), ...at(1), ...at(-1)],
    part: [0, 0, 0, 1, 1, 1, 2, 2, 2],
    triangles: [0, 1, 2, 3, 4, 5, 6, 7, 8],
  };
  const scene = { ...SCENE, place };
  const ray = { from: [3, 0, 0], way: [-1, 0, 0] };
  const without = (...names) => ({ ...ALL, part: (k) => !names.includes(place.parts[k].name) });
  const through = pick(scene, ray, ALL, null, true);
  assert.equal(named(scene, through), "pilot: hand, thumb tip"); // through a wall that is veiled
  assert.equal(named(scene, through.before), "canopy");
  near(through.before.point, [2, 0, 0]);
  const wall = pick(scene, ray, ALL, null, false);
  assert.equal(named(scene, wall), "wall"); // opaque, behind glass
  assert.equal(named(scene, wall.before), "canopy");
  const beside = pick(scene, { from: [3, 0.3, 0], way: [-1, 0, 0] }, without("wall"), null, true);
  assert.equal(named(scene, beside), "lever"); // no person there
  const glass = pick(scene, { from: [3, 0.3, 0], way: [-1, 0, 0] }, without("wall", "lever"), null, true);
  assert.equal(named(scene, glass), "canopy");
  assert.equal(glass.before, null);
  assert.ok(same(through, pick(scene, ray, ALL, null, true)) && !same(through, wall) && !same(wall, null));
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
  assert.equal(change({ share: 0.5, most: 0.5, was: 0.62 }), "−12.0");
  assert.equal(change({ share: 0.62, most: 0.62, was: 0.5 }), "+12.0");
  assert.equal(change({ share: 0.5, most: 0.5, was: 0.5004 }), "");
  assert.equal(change({ share: 0.4, most: 0.6, was: 0.5 }), "");
  assert.equal(change({ share: 0.1, most: 0.4, was: 0.5 }), "−10.0");
  assert.equal(range({ share: 0.5, most: 0.5 }), "50.0 %");
  assert.equal(range({ share: 0.4, most: 0.75 }), "40.0 to 75.0 %");
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

test("an eye looks along its sight with its head upright, and comes back", () => {
  const camera = new Camera();
  camera.aspect = 1.5;
  const before = camera.eye();
  camera.stand({ at: [1, 2, 3], sight: [0.8, 0, -0.6], up: [0.6, 0, 0.8] }, 1.2);
  near(camera.eye(), [1, 2, 3], 2e-3);
  const { x, y, z } = camera.axes();
  near(z, [-0.8, 0, 0.6]);
  near(y, [0.6, 0, 0.8]);
  near(vec.cross(x, y), z);
  camera.stand({ at: [0, 0, 0], sight: [1, 0, 0], up: [0, 1, 0] }, 1.2); // the head on its side
  near(camera.axes().y, [0, 1, 0]);
  camera.zoom(0.5);
  assert.ok(Math.abs(camera.angle - 0.6) < 1e-9 && camera.far < 0.01);
  assert.ok(camera.leave() && !camera.leave());
  near(camera.eye(), before);
  assert.ok(Math.abs(across(Math.PI / 2, 1) - Math.PI / 2) < 1e-9);
  assert.match(fieldWords("pilot", Math.PI / 2, 1), /90° high and 90° wide/);
});

test("the least gap is found, drawn without gaps that are not known, and the criterion that is nearest to failing", () => {
  const gaps = [NaN, 0.3, 0.1, NaN, 0.2];
  assert.equal(worstOf(gaps), 2);
  assert.equal(worstOf([NaN]), -1);
  assert.equal(path([0, 1, 2, 3, 4], gaps, (t) => 10 * t, (gap) => 100 * gap), "M10 30.0L20 10.0M40 20.0");
  assert.equal(path([0, 0.01], [0.3, 0.1], (t) => t, (gap) => gap), "M0 0.1");
  assert.equal(frameAt([0, 10, 20], 19.9), 1);
  assert.equal(frameAt([0, 10, 20], -5), 0);
  const near = nearestToFailing([{ name: "a", limit: 0 }, { name: "b", limit: 0.2 }], [[0.1, 0.3], [0.5, 0.25]]);
  assert.equal(near.name, "b");
  assert.equal(nearestToFailing([], []), null);
  assert.equal(startOf(600, 256), 512);
});

test("windows of a motion are let go by their bytes, what was looked at longest ago first", () => {
  const windows = new Map([[512, { bytes: 30 }], [0, { bytes: 30 }], [256, { bytes: 30 }], [768, { bytes: 30 }]]);
  assert.deepEqual(surplus(windows, 0, 120), []);
  assert.deepEqual(surplus(windows, 0, 119), [512]);
  assert.deepEqual(surplus(windows, 512, 60), [0, 256]);
  assert.deepEqual(surplus(windows, 512, 1), [0, 256]); // the one that is shown and the last that came
});

test("frames of a window are shown, and an unseen segment is neither drawn nor picked", () => {
  const body = { ...SCENE.bodies[0], radius: [0.2, 0.1], failing: [], touching: [[0, 29, 31]], colour: [1, 2, 3], unseen: 1 };
  body.frames = Float32Array.of(0, 0, 0, 0, 0, 1, 5, 0, 0, 5, 0, 1);
  const film = { bodies: [body], place: null, times: [0, 10, 20, 30], first: 2 };
  setFrame(film, 3);
  assert.deepEqual([...body.centres], [5, 0, 0, 5, 0, 1]);
  assert.deepEqual([...body.tint], [222, 36, 30, 255, 1, 2, 3, 0]);
  assert.deepEqual([...coloured({ ...body, unseen: undefined }, [])].slice(4), [1, 2, 3, 255]);
  assert.equal(pick(film, { from: [5, 3, 1], way: [0, -1, 0] }, ALL, null), null);
});

test("a distance has its components, and names are told apart", () => {
  assert.equal(components([0, 0, 0], [0.03, -0.04, 0]), "x +30.0, y −40.0, z +0.0");
  const lines = dimensionLines([0, 0, 0], [1, 2, 3]);
  assert.deepEqual(lines.map(({ to }) => to), [[1, 0, 0], [1, 2, 0], [1, 2, 3], [1, 2, 3]]);
  assert.deepEqual(thingOf("segment\tpilot\tright hand"), { person: "pilot", segment: "right hand" });
  assert.deepEqual(thingOf("part\tleft_stick"), { part: "left_stick" });
});

test("a file is named by what is in it, and words are broken into lines", () => {
  assert.equal(fileName(["my_study", "looking left", "0.420s"], "png"), "my_study_looking_left_0.420s.png");
  assert.equal(fileName(["../etc", "a/b: Fahrt nach Süd", undefined], "mp4"), "etc_a_b_Fahrt_nach_Süd.mp4");
  assert.equal(fileName(["", "//"], "png"), "picture.png");
  assert.deepEqual(broken("one two three", 7, (words) => words.length), ["one two", "three"]);
  assert.deepEqual(broken("everything", 3, (words) => words.length), ["everything"]);
});

test("a section of the picture is an axis, a side and a place for the film", () => {
  assert.deepEqual(planeOf([0, -1, 0, 0.3]), [1, -1, 0.3]); // y < 0.3 is cut away
  assert.deepEqual(planeOf([1, 0, 0, -0.5]), [0, 1, 0.5]);
  assert.equal(planeOf(null), null);
});

test("how far somebody is from the saved state, and what has moved, in words", () => {
  const body = (x, radius = 0.1) => ({ centres: Float32Array.of(0, 0, 0, x, 0, 0), radius: Float32Array.of(0.1, radius) });
  assert.equal(farthest(body(1), body(1)), 0);
  near([farthest(body(1.25), body(1)), farthest(body(1, 0.14), body(1))], [0.25, 0.04], 1e-6);
  assert.equal(farthest(body(1), { centres: new Float32Array(3), radius: new Float32Array(1) }), Infinity);
  assert.equal(movedWords([{ name: "seat_pan", by: 0 }, { name: "lever", by: 1e-6 }]), "");
  const rows = [{ name: "pilot", by: 0.0301, lead: "up to " }, { name: "seat_pan", by: 0.03 }, { name: "seat_back", by: 0.03 }];
  assert.equal(movedWords(rows), "pilot up to 30.1 mm, seat pan and 1 more 30.0 mm");
  const many = [1, 2, 3, 4, 5].map((k) => ({ name: `part ${k}`, by: k / 1000 }));
  assert.equal(movedWords(many), "part 5 5.0 mm, part 4 4.0 mm, part 3 3.0 mm, 2 more");
  assert.equal(movedWords([{ name: "pilot", by: Infinity }]), "pilot another body");
});

test("a part of the saved state is where a picture of it would have it", () => {
  assert.deepEqual(shiftOf({ shifts: { lever: [1, 0, 0] } }, "lever", null), [1, 0, 0]);
  assert.deepEqual(shiftOf({ shifts: {} }, "lever", null), [0, 0, 0]);
  const moves = [{ parts: ["lever"], by: [0, 3, 0] }];
  assert.deepEqual(shiftOf({ moves }, "lever", [{ parts: ["lever"], by: [0, 1, 0] }]), [0, 2, 0]);
  assert.deepEqual(shiftOf({ moves: [] }, "lever", moves), [0, -3, 0]);
  const place = { vertices: [0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9], part: [1, 1, 1, 0], triangles: [0, 1, 2], edges: [1, 2, 3, 3] };
  const veil = veilOfParts(place, new Map([[1, [0, 0, 5]]]));
  assert.deepEqual([...veil.vertices], [0, 0, 5, 1, 0, 5, 0, 1, 5]);
  assert.deepEqual([[...veil.triangles], [...veil.edges]], [[0, 1, 2], [1, 2]]);
});

test("each face of an envelope has its own colour", () => {
  const points = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1);
  const found = { points, faces: Uint32Array.of(0, 1, 2, 0, 2, 3), short: Uint8Array.of(0, 1), lines: Float32Array.of(0, 0, 0, 1, 1, 1) };
  const veil = veilOf(found, false);
  assert.deepEqual([...veil.part], [0, 0, 0, 1, 1, 1, 0, 0]);
  assert.deepEqual([...veil.edges], [6, 7]);
  assert.notDeepEqual(veil.looks[0], veilOf(found, true).looks[0]);
});

test("two states share a picture without a gap, and what is of no state is in both", () => {
  assert.deepEqual(stripes(0.25, 201), [{ state: 0, from: 0, to: 50 }, { state: 1, from: 50, to: 201 }]);
  assert.deepEqual(stripes(0, 200), [{ state: 1, from: 0, to: 200 }]);
  assert.deepEqual(stripes(1, 200), [{ state: 0, from: 0, to: 200 }]);
  assert.deepEqual([0.2, 0.3].map((across) => stateAt(0.25, across)), [0, 1]);
  assert.deepEqual([{}, { state: 0 }, { state: 1 }].map((thing) => isOf(thing, 1)), [true, false, true]);
  assert.deepEqual([0, 0.4, 1].map((wipe) => wipeWords(["old", "new"], wipe)),
    ["new alone", "old to the left of 40 %, new to the right", "old alone"]);
});

test("a section is called by the side that goes, and its place", () => {
  assert.deepEqual(sectionOf("left=0.3"), { axis: 1, sign: 1, at: 0.3 });
  assert.deepEqual(sectionOf("back"), { axis: 0, sign: -1, at: undefined });
  assert.equal(sectionWords([0, 1, 0, -0.3]), "left=0.3");
  assert.equal(sectionWords([-1, 0, 0, 0.25]), "back=0.25"); // -x + 0.25 > 0: what is behind 0.25
});

test("what is chosen has names, and what has these names is found again", () => {
  const hand = { name: "anna", segments: ["arm", "hand"], segment: [0, 1, 1], spheres: ["", "thumb", ""] };
  const centres = Float32Array.of(0, 0, 0, 1, 2, 3, 4, 5, 6);
  const scene = {
    bodies: [{ ...hand, radius: [1, 1, 1], centres }],
    place: { parts: [{ name: "left_sill" }], part: [0, 0], vertices: Float32Array.of(0, 0, 0, 2, 4, 6) },
  };
  for (const names of [["anna", "hand", "thumb"], ["anna", "hand"], ["left_sill"]]) {
    assert.deepEqual(namesOf(scene, chosenOf(scene, names)), names);
  }
  near(chosenOf(scene, ["left_sill"]).point, [1, 2, 3]);
  near(chosenOf(scene, ["anna", "hand", "thumb"]).point, [1, 2, 3]);
  assert.deepEqual(namesOf(scene, { kind: "body", body: 0, sphere: 2 }), ["anna", "hand"]);
  assert.equal(chosenOf(scene, ["bert", "hand"]), null);
  assert.ok(areAlike(scene.bodies, scene.bodies) && !areAlike([], scene.bodies));
});

test("numbers have a true minus, zero has none, and an overlap says what is allowed", () => {
  assert.deepEqual([marginWords(-0.00006), marginWords(0.04), marginWords(-4.25), marginWords(0)], ["−0.0001", "0.04", "−4.3", "0.0"]);
  assert.deepEqual([signed(-4.25), signed(-0.04), signed(3.654512)], ["−4.3", "0.0", "3.7"]);
  assert.equal(allowedWords({ mm: -4.2, allowed: 5 }), "5.0 allowed");
  assert.equal(allowedWords({ mm: -4.2, allowed: 0 }), "none allowed");
  assert.equal(allowedWords({ mm: 4.2, allowed: 5 }), "");
});

test("keys that an element needs are its own", () => {
  assert.ok(isOfElement("[", { name: "INPUT", type: "number" }));
  assert.ok(isOfElement(" ", { name: "BUTTON" }) && !isOfElement("]", { name: "BUTTON" }));
  assert.ok(isOfElement("ArrowLeft", { name: "INPUT", type: "range" }) && !isOfElement("?", { name: "INPUT", type: "range" }));
  assert.ok(!isOfElement(" ", { name: "BODY" }));
});

test("a step says its number and for how long it is taken", () => {
  assert.equal(stepWords(2, 3, "the motion is being read", 0.4), "Step 2 of 3: the motion is being read.");
  assert.equal(stepWords(2, 3, "the motion is being read", 4.9), "Step 2 of 3: the motion is being read, 4 s.");
});

test("a reach map's bands and ticks", () => {
  const levels = [0.5, 0.9, 0.95, 0.99];
  assert.deepEqual([0, 0.5, 0.89, 0.95, 1].map((share) => band(share, levels)), [0, 1, 1, 3, 4]);
  assert.deepEqual(bands(levels), ["under 50 %", "50 to 90 %", "90 to 95 %", "95 to 99 %", "99 % and more"]);
  assert.deepEqual(ticks(-230, 310), [-200, -100, 0, 100, 200, 300]);
  assert.deepEqual(ticks(0, 12), [0, 10]);
});

test("a verdict of a state that is being changed says so", () => {
  assert.equal(resultWords({ passed: true, now: true }), "✓ passes now");
  assert.equal(resultWords({ passed: false, now: true }), "✗ FAILS now");
  assert.equal(resultWords({ passed: false, now: false }), "✗ FAILED");
});

test("turns of eyes and head are told by their sides", () => {
  assert.equal(turnWords([15, -3.4]), "15° left, 3° down");
  assert.equal(turnWords([-0.4, 0.01]), "straight ahead");
  assert.equal(turnWords([15, -0.4]), "15° left");
  assert.equal(gazeWords({ eyes: [0, 5], head: [-25, 0], lack: 0 }), "Eyes 5° up in the head; head 25° right");
  assert.ok(gazeWords({ eyes: [35, 0], head: [60, 0], trunk: 30, lack: 2 }).endsWith("head 60° left; trunk 30° left: 2° beyond the turn of eyes, head and trunk"));
  assert.ok(gazeWords({ eyes: [35, 0], head: [60, 0], lack: 21.6 }).endsWith("22° beyond the turn of eyes and head"));
  const free = { free: [56, 51, 59, 48], error: 0.5 };
  assert.ok(freeWords({ ...free, fine: true }).startsWith("Free: 48.0 % to both eyes, 59.0 % to one at least"));
  assert.ok(freeWords({ ...free, fine: false }).endsWith("(± 0.5 points, while it turns at 0.5°)"));
});

test("verdicts are summed up: of whom, and not as passed where nothing was asked", () => {
  const head = { rows: [{ passed: true, asked: true }, { passed: true, asked: false }], warnings: [], waits: false };
  assert.equal(summary({ ...head, rows: head.rows.slice(0, 1) }, false, ""), "(all passed)");
  assert.equal(summary({ ...head, rows: head.rows.slice(0, 1) }, true, ""), "(all passed, but see below)");
  assert.equal(summary(head, false, "driver"), "(all passed for the one driver shown, 1 found nothing to look at)");
  assert.equal(summary({ ...head, rows: head.rows.slice(1) }, false, "driver"), "(nothing was asked)");
  assert.equal(summary({ ...head, rows: [] }, false, "driver"), "(nothing was asked)");
  assert.equal(summary({ ...head, rows: [], waits: true }, false, "driver"), "(motions are being judged)");
  const failed = [...head.rows, { passed: false, asked: true }];
  assert.equal(summary({ ...head, rows: failed, warnings: ["a"] }, true, "pilot"), "(1 failed for the one pilot shown, 1 found nothing to look at, 1 warning)");
});
