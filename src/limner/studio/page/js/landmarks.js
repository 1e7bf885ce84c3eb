// The 68 landmarks: which belong together, what each is called, and how three of them carry all.

/** @typedef {[number, number]} Point */
/** @typedef {{key: string, name: string, first: number, last: number, closed: boolean}} Part */

/** @type {Part[]} */
export const PARTS = [
  { key: "jaw", name: "jaw", first: 0, last: 16, closed: false },
  { key: "brow", name: "right brow", first: 17, last: 21, closed: false },
  { key: "brow", name: "left brow", first: 22, last: 26, closed: false },
  { key: "nose", name: "bridge of the nose", first: 27, last: 30, closed: false },
  { key: "nose", name: "base of the nose", first: 31, last: 35, closed: false },
  { key: "eye", name: "right eye", first: 36, last: 41, closed: true },
  { key: "eye", name: "left eye", first: 42, last: 47, closed: true },
  { key: "mouth", name: "outer lips", first: 48, last: 59, closed: true },
  { key: "mouth", name: "inner lips", first: 60, last: 67, closed: true },
];
export const KEYS = ["jaw", "brow", "nose", "eye", "mouth"];
export const COUNT = 68;
/** The three that place a template: outer corners of the eyes, and the chin. */
export const ANCHORS = [36, 45, 8];

const NAMED = new Map([
  [8, "chin"], [30, "tip of the nose"], [36, "right eye, outer corner"], [39, "right eye, inner corner"],
  [42, "left eye, inner corner"], [45, "left eye, outer corner"], [48, "right corner of the mouth"],
  [54, "left corner of the mouth"], [0, "jaw at the right ear"], [16, "jaw at the left ear"],
]);

/**
 * @param {number} index
 * @returns {Part}
 */
export function partOf(index) {
  const part = PARTS.find(({ first, last }) => index >= first && index <= last);
  if (!part) throw new RangeError(`landmark ${index}: there are 0 to ${COUNT - 1}`);
  return part;
}

/**
 * What a landmark is called; left and right are the person's.
 * @param {number} index
 */
export function nameOf(index) {
  const part = partOf(index);
  return NAMED.get(index) ?? `${part.name}, ${index - part.first + 1} of ${part.last - part.first + 1}`;
}

/**
 * The landmark nearest to a place, if within reach.
 * @param {Point[]} points
 * @param {Point} place
 * @param {number} reach
 * @param {(index: number) => boolean} [allowed]
 */
export function nearest(points, place, reach, allowed = () => true) {
  let best = -1;
  let least = reach;
  points.forEach(([x, y], index) => {
    const far = Math.hypot(x - place[0], y - place[1]);
    if (far <= least && allowed(index)) [best, least] = [index, far];
  });
  return best;
}

/**
 * A copy with one point moved, kept within the photo.
 * @param {Point[]} points
 * @param {number} index
 * @param {Point} to
 * @param {{width: number, height: number}} size
 * @returns {Point[]}
 */
export function moved(points, index, to, size) {
  const copy = points.slice();
  copy[index] = [clamp(to[0], 0, size.width - 1), clamp(to[1], 0, size.height - 1)];
  return copy;
}

/**
 * The affine map that takes three points to three others, applied to all points.
 * @param {Point[]} points
 * @param {Point[]} from three points not on one line
 * @param {Point[]} to
 * @returns {Point[]}
 */
export function carried(points, from, to) {
  const [[ax, ay], [bx, by], [cx, cy]] = from;
  const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  if (Math.abs(area) < 1e-9) throw new RangeError("three points on one line carry nothing");
  return points.map(([x, y]) => {
    const v = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
    const u = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area;
    const at = (/** @type {0 | 1} */ i) => to[0][i] * (1 - u - v) + to[1][i] * u + to[2][i] * v;
    return /** @type {Point} */ ([at(0), at(1)]);
  });
}

/**
 * Distance of the outer corners of the eyes.
 * @param {Point[]} points
 */
export function eyeDistance(points) {
  return Math.hypot(points[45][0] - points[36][0], points[45][1] - points[36][1]);
}

/**
 * How far points moved on average, in per cent of the distance of the eyes.
 * @param {Point[]} before
 * @param {Point[]} after
 */
export function meanShift(before, after) {
  const far = before.map(([x, y], i) => Math.hypot(after[i][0] - x, after[i][1] - y));
  return (100 * far.reduce((sum, d) => sum + d, 0)) / far.length / eyeDistance(before);
}

/** @param {number} value @param {number} low @param {number} high */
function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
