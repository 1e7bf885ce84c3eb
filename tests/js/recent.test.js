// Of what the server keeps, the latest drawing of each face of each photo is shown.
import assert from "node:assert/strict";
import test from "node:test";
import { latest } from "../../src/limner/studio/page/js/recent.js";

test("the latest of each face of each photo, in their order", () => {
  const kept = [["a", 0, 5], ["b", 0, 4], ["a", 0, 3], ["a", 1, 2], ["b", 0, 1]].map(([photo, face, drawing]) => ({ photo, drawing, wish: { face } }));
  assert.deepEqual(latest(kept).map(({ drawing }) => drawing), [5, 4, 2]);
  assert.deepEqual(latest([]), []);
});
