// Zooming keeps what is under the pointer; to the screen and back is the same place.
import assert from "node:assert/strict";
import test from "node:test";
import { fit, toPicture, toScreen, zoomed } from "../../src/limner/studio/page/js/viewport.js";

test("a fitted picture lies within the room, centred, and touches a side", () => {
  const view = fit(640, 480, 300, 500, 10);
  const [left, top] = toScreen(view, [0, 0]);
  const [right, bottom] = toScreen(view, [640, 480]);
  assert.ok(Math.abs(left - 10) < 1e-9 && Math.abs(right - 290) < 1e-9);
  assert.ok(Math.abs(top + bottom - 500) < 1e-9);
});

test("zoom keeps the place under the pointer, within its limits", () => {
  const view = fit(640, 480, 300, 500);
  const at = [120, 200];
  const before = toPicture(view, at);
  const after = toPicture(zoomed(view, 3, at, 0.01, 50), at);
  before.forEach((value, axis) => assert.ok(Math.abs(value - after[axis]) < 1e-9));
  assert.equal(zoomed(view, 1e9, at, 0.01, 50).scale, 50);
  assert.equal(zoomed(view, 1e-9, at, 0.01, 50).scale, 0.01);
});
