// A frame as the protocol describes it, byte by byte, comes back; a short one is refused.
import assert from "node:assert/strict";
import test from "node:test";
import { decode } from "../../src/limner/studio/page/js/frames.js";

function frame({ strokes = [[[0, 0], [10, -10]], [[5, 6], [7, 8], [9, 10]]], rev = 4000000000 } = {}) {
  const count = strokes.flat().length;
  const bytes = new ArrayBuffer(24 + 4 * (strokes.length + 1) + 4 * count + 2 * strokes.length);
  const view = new DataView(bytes);
  view.setUint8(0, 1);
  view.setUint32(4, rev, true);
  view.setUint32(8, strokes.length, true);
  view.setUint32(12, count, true);
  view.setFloat32(16, 0.5, true);
  let at = 24;
  let end = 0;
  view.setUint32(at, 0, true);
  for (const stroke of strokes) view.setUint32((at += 4), (end += stroke.length), true);
  at += 4;
  for (const value of strokes.flat(2)) {
    view.setInt16(at, value, true);
    at += 2;
  }
  strokes.forEach((_, i) => view.setUint8(at + i, i + 3));
  strokes.forEach((_, i) => view.setUint8(at + strokes.length + i, i + 1));
  return bytes;
}

test("strokes, points, unit, regions and rev come back", () => {
  const { kind, rev, lines, regions } = decode(frame());
  assert.deepEqual([kind, rev, lines.unit], [1, 4000000000, 0.5]);
  assert.deepEqual([...lines.offsets], [0, 2, 5]);
  assert.deepEqual([...lines.points], [0, 0, 10, -10, 5, 6, 7, 8, 9, 10]);
  assert.deepEqual([...regions], [3, 4]);
  assert.deepEqual([...lines.layer], [1, 2]);
});

test("an empty drawing is a drawing", () => {
  assert.equal(decode(frame({ strokes: [] })).lines.points.length, 0);
});

test("a frame that was cut off is refused, wherever", () => {
  const whole = frame();
  for (let length = 0; length < whole.byteLength; length += 1) assert.throws(() => decode(whole.slice(0, length)), RangeError);
});

test("a plan's samples come back, joints too", () => {
  const [n, dof] = [3, 2];
  const bytes = new ArrayBuffer(24 + n * (4 + 4 + 4 * dof + 4 + 1));
  const view = new DataView(bytes);
  view.setUint8(0, 2);
  view.setUint32(8, n, true);
  view.setUint32(12, dof, true);
  view.setFloat32(16, 0.25, true);
  for (let i = 0; i < n; i += 1) {
    view.setFloat32(24 + 4 * i, i / 2, true);
    view.setInt16(24 + 4 * n + 4 * i, -i, true);
    for (let k = 0; k < dof; k += 1) view.setFloat32(24 + 8 * n + 4 * (dof * i + k), 10 * i + k, true);
    view.setInt32(24 + (8 + 4 * dof) * n + 4 * i, i - 1, true);
    view.setUint8(24 + (12 + 4 * dof) * n + i, i % 2);
  }
  const { plan } = decode(bytes);
  assert.deepEqual([...plan.times], [0, 0.5, 1]);
  assert.deepEqual([...plan.points], [0, 0, -1, 0, -2, 0]);
  assert.deepEqual([...plan.joints], [0, 1, 10, 11, 20, 21]);
  assert.deepEqual([...plan.line], [-1, 0, 1]);
  assert.deepEqual([...plan.draws], [0, 1, 0]);
  assert.throws(() => decode(bytes.slice(0, -1)), RangeError);
});
