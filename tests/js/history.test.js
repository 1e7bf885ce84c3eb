// Undo and redo give back the very versions that were there.
import assert from "node:assert/strict";
import test from "node:test";
import { History } from "../../src/limner/studio/page/js/history.js";

test("undo and redo are inverse", () => {
  const history = new History("a");
  for (const version of "bcd") history.push(version);
  assert.equal(history.undo(), "c");
  assert.equal(history.undo(), "b");
  assert.equal(history.redo(), "c");
  assert.equal(history.redo(), "d");
  assert.equal(history.redo(), "d");
});

test("a new version forgets what was undone, not the first", () => {
  const history = new History("a", 3);
  for (const version of "bcdef") history.push(version);
  assert.equal(history.first, "a");
  assert.equal(history.versions.length, 3);
  history.undo();
  history.push("x");
  assert.equal(history.canRedo, false);
  assert.equal(history.undo(), "e");
  for (let i = 0; i < 9; i += 1) history.undo();
  assert.equal(history.present, "a");
  assert.equal(history.canUndo, false);
});
