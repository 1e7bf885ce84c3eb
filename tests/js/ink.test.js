// Ink drawn bit by bit is the ink drawn at once; each point finds its stroke.
import assert from "node:assert/strict";
import test from "node:test";
import { Ink, orderColour, pageOf, strokeAt } from "../../src/limner/studio/page/js/ink.js";

/** Records the segments that are drawn. */
class Recorder {
  constructor() {
    this.segments = [];
    this.at = [0, 0];
  }
  beginPath() {}
  stroke() {}
  save() {}
  restore() {}
  moveTo(x, y) {
    this.at = [x, y];
  }
  lineTo(x, y) {
    this.segments.push([...this.at, x, y].join());
    this.at = [x, y];
  }
}

const lines = { offsets: Uint32Array.from([0, 3, 4, 9]), points: Int16Array.from(Array.from({ length: 18 }, (_, i) => (i * 37) % 101)), unit: 0.01 };

function drawn(steps, look = {}) {
  const recorder = new Recorder();
  const ink = new Ink(recorder);
  ink.lines = lines;
  ink.look = look;
  ink.place(2, 5, 7, 0.5);
  for (const until of steps) ink.advance(until);
  return recorder.segments;
}

test("every point is in its own stroke", () => {
  assert.deepEqual(Array.from({ length: 9 }, (_, i) => strokeAt(lines.offsets, i)), [0, 0, 0, 1, 2, 2, 2, 2, 2]);
});

test("ink in steps is the ink at once, whatever its look", () => {
  for (const look of [{}, { byOrder: true }, { travel: true }, { red: new Set([2]) }]) {
    const whole = new Set(drawn([9], look));
    const bits = new Set(drawn([1, 2, 3, 4, 5, 6, 7, 8, 9, 99], look));
    for (const segment of whole) assert.ok(bits.has(segment), `${segment} is missing`);
    assert.ok(whole.size >= 2 + 1 + 4);
  }
});

test("without moves of the lifted pen no segment joins two strokes", () => {
  const link = [lines.points[4], lines.points[5], lines.points[6], lines.points[7]].map((value, i) => (i % 2 ? 7 : 5) + value * lines.unit * 2).join();
  assert.ok(!drawn([9]).includes(link));
  assert.ok(drawn([9], { travel: true }).some((segment) => segment === link));
});

test("each stroke has the colour of its pen, red and order go before", () => {
  const colours = (look, layer) => {
    const recorder = new Recorder();
    const seen = [];
    recorder.lineTo = () => seen.push(recorder.strokeStyle);
    const ink = new Ink(recorder);
    ink.lines = { ...lines, layer };
    ink.look = { ink: "black", ...look };
    ink.place(2, 5, 7, 0.5);
    ink.advance(9);
    return [...new Set(seen)];
  };
  const inks = ["#aa0000", "#00bb00"];
  assert.deepEqual(colours({ inks }, Uint8Array.from([1, 0, 1])), ["#00bb00", "#aa0000"]);
  assert.deepEqual(colours({ inks, red: new Set([0, 1]), accent: "red" }, Uint8Array.from([1, 0, 1])), ["red", "#00bb00"]);
  assert.deepEqual(colours({}, Uint8Array.from([1, 0, 1])), ["black"]);
  assert.equal(colours({ inks, byOrder: true }, Uint8Array.from([1, 0, 1])).length, 3);
});

test("a single pen draws in the ink of the sheet", () => {
  const page = { width_mm: 148, height_mm: 210, margin_mm: 10 };
  const pen = { name: "black", width_mm: 0.5, colour: "#000000" };
  assert.equal(pageOf({ page, pen_mm: 0.5, pens: [pen] }).inks, undefined);
  assert.deepEqual(pageOf({ page, pen_mm: 0.5, pens: [pen, { ...pen, colour: "#ff0000" }] }).inks, ["#000000", "#ff0000"]);
});

test("colours by order differ from first to last", () => {
  assert.equal(new Set([0, 0.25, 0.5, 0.75, 1].map(orderColour)).size, 5);
});
