// A chain of joints: rotations stay rotations, a plane arm is where trigonometry says.
import assert from "node:assert/strict";
import test from "node:test";
import { apply, frames, identity, motion, origin, place, times } from "../../src/limner/studio/page/js/kinematics.js";

const joint = (name, xyz, axis, type = "revolute", rpy = [0, 0, 0]) => ({ name, type, parent: "", child: "", xyz, rpy, axis });
const near = (a, b) => a.forEach((value, i) => assert.ok(Math.abs(value - b[i]) < 1e-9, `${a} is not ${b}`));

test("two links in a plane", () => {
  const chain = [joint("a", [0, 0, 0], [0, 0, 1]), joint("b", [2, 0, 0], [0, 0, 1]), joint("tip", [1, 0, 0], [0, 0, 1], "fixed")];
  const [a, b] = [0.3, -1.1];
  const found = frames(chain, { a, b });
  assert.equal(found.length, 4);
  near(place(found[3]), [2 * Math.cos(a) + Math.cos(a + b), 2 * Math.sin(a) + Math.sin(a + b), 0]);
});

test("a turn of any axis is a rotation, and back again is none", () => {
  const axis = [0.48, 0.6, 0.64];
  const turn = motion(joint("j", [0, 0, 0], axis), 0.9);
  near(times(turn, motion(joint("j", [0, 0, 0], axis), -0.9)), identity());
  near(apply(turn, axis), axis);
});

test("a URDF origin turns about x, then y, then z", () => {
  near(apply(origin([1, 2, 3], [Math.PI / 2, 0, 0]), [0, 1, 0]), [1, 2, 4]);
  near(apply(origin([0, 0, 0], [Math.PI / 2, 0, Math.PI / 2]), [0, 1, 0]), [0, 0, 1]);
  near(apply(origin([0, 0, 0], [0, Math.PI / 2, Math.PI / 2]), [1, 0, 0]), [0, 0, -1]);
});

test("a sliding joint moves along its axis", () => near(place(frames([joint("s", [0, 0, 1], [0, 0, 1], "prismatic")], { s: 0.25 })[1]), [0, 0, 1.25]));
