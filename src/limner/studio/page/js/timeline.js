// Times of a pen's path go in; where the pen is, and how much ink there is, at any time comes out.

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {{x: number, y: number, down: boolean, ink: number, sample: number, share: number}} PenState x, y in mm; ink: samples passed */

/** The pen's path as samples in time. */
export class Timeline {
  /**
   * @param {Float32Array | Float64Array} times of each sample [s], never falling
   * @param {Int16Array} points x, y of each, in units
   * @param {Uint8Array} down whether the pen is down from this sample to the next
   * @param {number} unit [mm]
   */
  constructor(times, points, down, unit) {
    this.times = times;
    this.points = points;
    this.down = down;
    this.unit = unit;
    this.last = 0;
  }

  get duration() {
    return this.times.length ? this.times[this.times.length - 1] : 0;
  }

  /**
   * The last sample at or before a time. Playing forwards this looks only at the next few.
   * @param {number} time
   */
  sample(time) {
    const { times } = this;
    let at = this.last;
    if (times[at] > time || times[Math.min(at + 16, times.length - 1)] <= time) at = search(times, time);
    while (at + 1 < times.length && times[at + 1] <= time) at += 1;
    this.last = at;
    return at;
  }

  /**
   * @param {number} time
   * @returns {PenState}
   */
  at(time) {
    const { times, points, down } = this;
    const i = this.sample(time);
    const j = Math.min(i + 1, times.length - 1);
    const span = times[j] - times[i];
    const share = span > 0 ? Math.min(Math.max((time - times[i]) / span, 0), 1) : 0;
    const between = (/** @type {number} */ axis) =>
      this.unit * (points[2 * i + axis] + share * (points[2 * j + axis] - points[2 * i + axis]));
    return { x: between(0), y: between(1), down: Boolean(down[i]), ink: i + 1, sample: i, share };
  }
}

/**
 * A timeline from strokes alone, at even speeds: for when nobody has planned yet.
 * @param {Lines} lines
 * @param {{draw: number, travel: number, lift: number}} speed mm/s, mm/s, s
 */
export function estimate(lines, { draw, travel, lift }) {
  const { offsets, points, unit } = lines;
  const total = offsets[offsets.length - 1] ?? 0;
  const times = new Float64Array(total);
  const down = new Uint8Array(total).fill(1);
  let time = 0;
  let stroke = 0;
  for (let i = 0; i < total; i += 1) {
    const starts = i === offsets[stroke];
    if (starts) stroke += 1;
    if (i) {
      const far = Math.hypot(points[2 * i] - points[2 * i - 2], points[2 * i + 1] - points[2 * i - 1]) * unit;
      time += starts ? far / travel + 2 * lift : far / draw;
      if (starts) down[i - 1] = 0;
    }
    times[i] = time;
  }
  return new Timeline(times, points, down, unit);
}

/**
 * The timeline of a plan, the strokes as its samples draw them, and how many of their points there are at each sample.
 * @param {import("./frames.js").Plan} plan
 * @returns {{timeline: Timeline, lines: Lines, inkAt: Uint32Array}}
 */
export function fromPlan({ times, points, unit, line, draws }) {
  const samples = times.length;
  const [ends, kept] = [[0], /** @type {number[]} */ ([])];
  const inkAt = new Uint32Array(samples);
  const down = new Uint8Array(samples);
  let stroke = -1;
  for (let i = 0; i < samples; i += 1) {
    if (draws[i] && i) {
      down[i - 1] = 1;
      // A stroke begins at the sample before the first that draws.
      if (line[i] !== stroke) {
        if (kept.length) ends.push(kept.length / 2);
        kept.push(points[2 * i - 2], points[2 * i - 1]);
        stroke = line[i];
      }
      kept.push(points[2 * i], points[2 * i + 1]);
    }
    inkAt[i] = kept.length / 2;
  }
  if (kept.length) ends.push(kept.length / 2);
  const lines = { offsets: Uint32Array.from(ends), points: Int16Array.from(kept), unit };
  return { timeline: new Timeline(times, points, down, unit), lines, inkAt };
}

/** @param {Float32Array | Float64Array} times @param {number} time */
function search(times, time) {
  let low = 0;
  let high = Math.max(0, times.length - 1);
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
