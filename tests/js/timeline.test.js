// Time never runs backwards on a timeline; the pen is where it should be, forwards and backwards.
import assert from "node:assert/strict";
import test from "node:test";
import { estimate, fromPlan, Timeline } from "../../src/limner/studio/page/js/timeline.js";

const lines = { offsets: Uint32Array.from([0, 2, 4]), points: Int16Array.from([0, 0, 1000, 0, 1000, 3000, 1000, 2000]), unit: 0.01 };
const speed = { draw: 10, travel: 30, lift: 0.5 };

test("even speeds give the times of the way", () => {
  const { times, down } = estimate(lines, speed);
  assert.deepEqual([...times], [0, 1, 3, 4]);
  assert.deepEqual([...down], [1, 0, 1, 1]);
});

test("the pen is between its samples, lifted between strokes", () => {
  const timeline = estimate(lines, speed);
  const near = (pen, x, y, down) => {
    assert.ok(Math.hypot(pen.x - x, pen.y - y) < 1e-6, `${pen.x}, ${pen.y}`);
    assert.equal(pen.down, down);
  };
  near(timeline.at(0.5), 5, 0, true);
  near(timeline.at(2), 10, 15, false);
  near(timeline.at(3.5), 10, 25, true);
  near(timeline.at(0.25), 2.5, 0, true);
  near(timeline.at(99), 10, 20, true);
  near(timeline.at(-1), 0, 0, true);
});

test("looking up in any order gives what a plain search gives", () => {
  const times = Float32Array.from({ length: 500 }, (_, i) => Math.floor(i / 3));
  const timeline = new Timeline(times, new Int16Array(1000), new Uint8Array(500), 0.01);
  let seed = 1;
  for (let i = 0; i < 2000; i += 1) {
    seed = (seed * 48271) % 2147483647;
    const time = (seed % 20000) / 100 - 10;
    const plain = Math.max(0, times.findLastIndex((t) => t <= time));
    assert.equal(timeline.sample(time), plain, `at ${time}`);
  }
});

test("nothing drawn takes no time", () => {
  assert.equal(estimate({ offsets: new Uint32Array(1), points: new Int16Array(0), unit: 0.01 }, speed).duration, 0);
});

test("a plan's strokes begin where the pen comes down, and each sample knows its ink", () => {
  const plan = {
    times: Float32Array.from([0, 1, 2, 3, 4, 5, 6]), points: Int16Array.from([0, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]), unit: 1, dof: 0,
    joints: new Float32Array(0), line: Int32Array.from([-1, 0, 0, 0, -1, 1, -1]), draws: Uint8Array.from([0, 0, 1, 1, 0, 1, 0]),
  };
  const { timeline, lines, inkAt } = fromPlan(plan);
  assert.deepEqual([...lines.offsets], [0, 3, 5]);
  assert.deepEqual([...lines.points], [1, 0, 2, 0, 3, 0, 4, 0, 5, 0]);
  assert.deepEqual([...inkAt], [0, 0, 2, 3, 3, 5, 5]);
  assert.deepEqual([0.5, 1.5, 2.5, 3.5, 4.5, 5.5].map((time) => timeline.at(time).down), [false, true, true, false, true, false]);
  assert.deepEqual([...fromPlan({ ...plan, draws: new Uint8Array(7) }).lines.offsets], [0]);
});
