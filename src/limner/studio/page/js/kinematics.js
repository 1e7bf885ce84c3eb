// A robot's joints and their positions go in; where each of its links is, in the frame of its base, comes out.

/** @typedef {number[]} Matrix 4 by 4, row by row */
/** @typedef {{name: string, type: string, parent: string, child: string, xyz: number[], rpy: number[], axis: number[]}} Joint lengths in m, angles in rad */

/** @returns {Matrix} */
export function identity() {
  return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
}

/**
 * @param {Matrix} a
 * @param {Matrix} b
 * @returns {Matrix}
 */
export function times(a, b) {
  const product = new Array(16).fill(0);
  for (let i = 0; i < 4; i += 1) {
    for (let j = 0; j < 4; j += 1) {
      for (let k = 0; k < 4; k += 1) product[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    }
  }
  return product;
}

/**
 * Rotation about fixed x, then y, then z, and a shift: the origin of a URDF joint.
 * @param {number[]} xyz
 * @param {number[]} rpy
 * @returns {Matrix}
 */
export function origin([x, y, z], [roll, pitch, yaw]) {
  const [cr, sr, cp, sp, cy, sy] = [Math.cos(roll), Math.sin(roll), Math.cos(pitch), Math.sin(pitch), Math.cos(yaw), Math.sin(yaw)];
  return [
    cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x,
    sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y,
    -sp, cp * sr, cp * cr, z,
    0, 0, 0, 1,
  ];
}

/**
 * The motion of one joint: a turn about its axis, or a shift along it.
 * @param {Joint} joint
 * @param {number} q rad or m
 * @returns {Matrix}
 */
export function motion(joint, q) {
  const [x, y, z] = joint.axis;
  if (joint.type === "prismatic") return [1, 0, 0, x * q, 0, 1, 0, y * q, 0, 0, 1, z * q, 0, 0, 0, 1];
  if (joint.type === "fixed") return identity();
  const [c, s] = [Math.cos(q), Math.sin(q)];
  const v = 1 - c;
  return [
    x * x * v + c, x * y * v - z * s, x * z * v + y * s, 0,
    y * x * v + z * s, y * y * v + c, y * z * v - x * s, 0,
    z * x * v - y * s, z * y * v + x * s, z * z * v + c, 0,
    0, 0, 0, 1,
  ];
}

/**
 * Where the frames of a chain are, the base first.
 * @param {Joint[]} joints from the base to the tip
 * @param {Record<string, number>} positions of those that move, by name
 * @returns {Matrix[]}
 */
export function frames(joints, positions) {
  const found = [identity()];
  for (const joint of joints) {
    const here = times(found[found.length - 1], origin(joint.xyz, joint.rpy));
    found.push(times(here, motion(joint, positions[joint.name] ?? 0)));
  }
  return found;
}

/**
 * The origin of a frame.
 * @param {Matrix} matrix
 * @returns {[number, number, number]}
 */
export function place(matrix) {
  return [matrix[3], matrix[7], matrix[11]];
}

/**
 * A point through a frame.
 * @param {Matrix} matrix
 * @param {number[]} point
 * @returns {[number, number, number]}
 */
export function apply(matrix, [x, y, z]) {
  const row = (/** @type {number} */ i) => matrix[4 * i] * x + matrix[4 * i + 1] * y + matrix[4 * i + 2] * z + matrix[4 * i + 3];
  return [row(0), row(1), row(2)];
}
