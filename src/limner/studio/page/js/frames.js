// A binary frame of the server goes in; the strokes in it come out, without a copy.

export const DRAWING = 1;
export const PLAN = 2;
const HEAD = 24;

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {{kind: number, rev: number, lines: Lines, regions: Uint8Array, rest: {at: number}}} Frame */

/**
 * Reads the head, the ends of the strokes and their points.
 * @param {ArrayBuffer} buffer
 * @returns {Frame}
 */
export function decode(buffer) {
  if (buffer.byteLength < HEAD) throw new RangeError(`a frame of ${buffer.byteLength} bytes: its head has ${HEAD}`);
  const head = new DataView(buffer);
  const [kind, rev] = [head.getUint8(0), head.getUint32(4, true)];
  const [strokes, count, unit] = [head.getUint32(8, true), head.getUint32(12, true), head.getFloat32(16, true)];
  const ends = HEAD + 4 * (strokes + 1);
  const end = ends + 4 * count;
  if (buffer.byteLength < end + strokes) throw new RangeError(`a frame of ${buffer.byteLength} bytes: ${end + strokes} were announced`);
  const lines = { offsets: new Uint32Array(buffer, HEAD, strokes + 1), points: new Int16Array(buffer, ends, 2 * count), unit };
  return { kind, rev, lines, regions: new Uint8Array(buffer, end, strokes), rest: { at: end + strokes } };
}
