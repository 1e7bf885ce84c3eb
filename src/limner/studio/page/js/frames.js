// A binary frame of the server goes in; the strokes in it come out, without a copy.

export const DRAWING = 1;
export const PLAN = 2;
const HEAD = 24;

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {{times: Float32Array, points: Int16Array, unit: number, dof: number, joints: Float32Array, line: Int32Array, draws: Uint8Array}} Plan samples: the pen's tip, the joints, the line that is drawn (-1 in travel), whether the move that ends there draws */
/** @typedef {{kind: number, rev: number, lines?: Lines, regions?: Uint8Array, plan?: Plan}} Frame */

/**
 * Reads the head, and what the kind of frame holds.
 * @param {ArrayBuffer} buffer
 * @returns {Frame}
 */
export function decode(buffer) {
  if (buffer.byteLength < HEAD) throw new RangeError(`a frame of ${buffer.byteLength} bytes: its head has ${HEAD}`);
  const head = new DataView(buffer);
  const [kind, rev, unit] = [head.getUint8(0), head.getUint32(4, true), head.getFloat32(16, true)];
  const [first, second] = [head.getUint32(8, true), head.getUint32(12, true)];
  return { kind, rev, ...(kind === PLAN ? { plan: planOf(buffer, first, second, unit) } : drawingOf(buffer, first, second, unit)) };
}

/** The ends of the strokes, their points, their regions, their pens. @param {ArrayBuffer} buffer @param {number} strokes @param {number} count @param {number} unit */
function drawingOf(buffer, strokes, count, unit) {
  const ends = HEAD + 4 * (strokes + 1);
  const end = ends + 4 * count;
  whole(buffer, end + 2 * strokes);
  const layer = new Uint8Array(buffer, end + strokes, strokes);
  const lines = { offsets: new Uint32Array(buffer, HEAD, strokes + 1), points: new Int16Array(buffer, ends, 2 * count), unit, layer };
  return { lines, regions: new Uint8Array(buffer, end, strokes) };
}

/** @param {ArrayBuffer} buffer @param {number} samples @param {number} dof @param {number} unit @returns {Plan} */
function planOf(buffer, samples, dof, unit) {
  const points = HEAD + 4 * samples;
  const joints = points + 4 * samples;
  const line = joints + 4 * samples * dof;
  const draws = line + 4 * samples;
  whole(buffer, draws + samples);
  return {
    times: new Float32Array(buffer, HEAD, samples), points: new Int16Array(buffer, points, 2 * samples), unit, dof,
    joints: new Float32Array(buffer, joints, samples * dof), line: new Int32Array(buffer, line, samples), draws: new Uint8Array(buffer, draws, samples),
  };
}

/** @param {ArrayBuffer} buffer @param {number} length */
function whole(buffer, length) {
  if (buffer.byteLength < length) throw new RangeError(`a frame of ${buffer.byteLength} bytes: ${length} were announced`);
}
