// The 68 landmarks: every one has a part and a name; three carry all the others.
import assert from "node:assert/strict";
import test from "node:test";
import { ANCHORS, carried, COUNT, meanShift, moved, nameOf, nearest, partOf, PARTS } from "../../src/limner/studio/page/js/landmarks.js";

const face = Array.from({ length: COUNT }, (_, i) => [100 + 37 * Math.cos(i * 1.7), 90 + 41 * Math.sin(i * 2.3)]);

test("each landmark belongs to exactly one part and has a name of its own", () => {
  const names = new Set();
  for (let i = 0; i < COUNT; i += 1) {
    assert.equal(PARTS.filter(({ first, last }) => i >= first && i <= last).length, 1);
    names.add(nameOf(i));
  }
  assert.equal(names.size, COUNT);
  assert.throws(() => partOf(COUNT), RangeError);
});

test("carried points: the three arrive, ratios along lines stay", () => {
  const from = ANCHORS.map((i) => face[i]);
  const to = [[10, 12], [80, 20], [40, 130]];
  const points = carried([...face, [(from[0][0] + from[1][0]) / 2, (from[0][1] + from[1][1]) / 2]], from, to);
  ANCHORS.forEach((anchor, i) => to[i].forEach((value, axis) => assert.ok(Math.abs(points[anchor][axis] - value) < 1e-9)));
  const middle = points[COUNT];
  assert.ok(Math.hypot(middle[0] - 45, middle[1] - 16) < 1e-9);
  assert.throws(() => carried(face, [[0, 0], [1, 1], [2, 2]], to), RangeError);
});

test("carried there and back is where it was", () => {
  const from = ANCHORS.map((i) => face[i]);
  const to = [[10, 12], [80, 20], [40, 130]];
  const back = carried(carried(face, from, to), to, from);
  assert.ok(meanShift(face, back) < 1e-9);
});

test("a moved point stays in the photo, the others where they are", () => {
  const points = moved(face, 8, [-5, 1e6], { width: 200, height: 100 });
  assert.deepEqual(points[8], [0, 99]);
  assert.deepEqual(points.filter((_, i) => i !== 8), face.filter((_, i) => i !== 8));
  assert.notDeepEqual(face[8], [0, 99]);
});

test("nearest finds a point within reach and none beyond", () => {
  assert.equal(nearest([[0, 0], [10, 0]], [9, 1], 5), 1);
  assert.equal(nearest([[0, 0], [10, 0]], [5, 9], 5), -1);
  assert.equal(nearest([[0, 0], [10, 0]], [9, 1], 50, (i) => i === 0), 0);
});
