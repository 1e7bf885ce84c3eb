// Numbers as people read them.
import assert from "node:assert/strict";
import test from "node:test";
import { clock, count, duration, length, percent, plural, sentence } from "../../src/limner/studio/page/js/format.js";

test("times", () => {
  assert.deepEqual([0, 59.4, 59.6, 125, 3600, 5000].map(duration), ["0 s", "59 s", "1 min 00 s", "2 min 05 s", "1 h 00 min", "1 h 23 min"]);
  assert.deepEqual([0, 61, 600].map(clock), ["0:00", "1:01", "10:00"]);
});

test("lengths, counts and shares", () => {
  assert.deepEqual([0.4, 570, 1600, 12345].map(length), ["0 mm", "570 mm", "1.60 m", "12.3 m"]);
  assert.deepEqual([count(1234.4), percent(0.824), plural(1, "stroke"), plural(2, "stroke")], ["1,234", "82 %", "1 stroke", "2 strokes"]);
});

test("what is not known is a dash", () => {
  for (const say of [duration, length, count, percent]) assert.deepEqual([say(null), say(undefined)], ["–", "–"]);
});

test("errors are sentences", () => {
  assert.equal(sentence("photo: is an animation; use a single picture"), "The photo is an animation; use a single picture.");
  assert.equal(sentence("Is it running?"), "Is it running?");
});
