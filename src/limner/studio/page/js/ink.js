// Strokes on a page go in; paper, ink and the pen's ways between strokes come out on a canvas, a little more at a time.

/** @typedef {{offsets: Uint32Array, points: Int16Array, unit: number, layer?: Uint8Array}} Lines points are x, y in units [mm] from the upper left corner, y down; stroke k has points offsets[k] to offsets[k + 1] and the pen layer[k] */
/** @typedef {{width_mm: number, height_mm: number, margin_mm: number, pen_mm: number, inks?: string[]}} Page inks: the colour of each pen, where there are several */
/** @typedef {{travel?: boolean, byOrder?: boolean, ink?: string, accent?: string, red?: Set<number>, inks?: string[]}} Look */

/** Of the red pencil, on paper that is light in any theme. */
export const RED = "#b8361c";

/** @type {Lines} */
export const NOTHING = { offsets: new Uint32Array(1), points: new Int16Array(0), unit: 0.01 };

/**
 * The page of a drawing's report. A single pen has the colour of ink on the sheet, several have their own.
 * @param {any} report
 * @returns {Page}
 */
export function pageOf(report) {
  const inks = report.pens?.length > 1 ? { inks: report.pens.map((/** @type {any} */ pen) => pen.colour) } : {};
  return { ...report.page, pen_mm: report.pen_mm, ...inks };
}

/** @param {Lines} lines */
export function pointCount(lines) {
  return lines.offsets[lines.offsets.length - 1] ?? 0;
}

/**
 * The stroke that a point belongs to.
 * @param {Uint32Array} offsets
 * @param {number} index
 */
export function strokeAt(offsets, index) {
  let low = 0;
  let high = offsets.length - 2;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (offsets[middle] <= index) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * From blue-black over violet to the red of the pencil, early to late.
 * @param {number} share 0 to 1
 */
export function orderColour(share) {
  return `hsl(${Math.round(228 + 132 * share)} ${Math.round(62 + 8 * share)}% ${Math.round(34 + 10 * share)}%)`;
}

/** Draws lines on a canvas of which only what is new is drawn. */
export class Ink {
  /** @param {CanvasRenderingContext2D} context */
  constructor(context) {
    this.context = context;
    /** @type {Lines} */
    this.lines = NOTHING;
    /** @type {Look} */
    this.look = {};
    this.drawn = 0;
    this.scale = 1;
    this.x = 0;
    this.y = 0;
    this.widthPx = 1;
  }

  /**
   * Where the page lies: pixels per mm, and the pixel of its upper left corner.
   * @param {number} scale
   * @param {number} x
   * @param {number} y
   * @param {number} penMm
   */
  place(scale, x, y, penMm) {
    this.scale = scale * this.lines.unit;
    this.x = x;
    this.y = y;
    this.widthPx = Math.max(penMm * scale, 0.7);
    this.drawn = 0;
  }

  /**
   * Draws from the point drawn last up to a number of points; the caller clears before going back.
   * @param {number} until
   */
  advance(until) {
    const { offsets } = this.lines;
    const end = Math.min(until, pointCount(this.lines));
    if (end <= this.drawn) return;
    this._pen();
    let stroke = strokeAt(offsets, this.drawn);
    while (stroke < offsets.length - 1 && offsets[stroke] < end) {
      this._stroke(stroke, Math.max(this.drawn, offsets[stroke]), Math.min(end, offsets[stroke + 1]));
      stroke += 1;
    }
    this.context.stroke();
    this.drawn = end;
  }

  _pen() {
    const { context, look } = this;
    context.lineCap = "round";
    context.lineJoin = "round";
    context.lineWidth = this.widthPx;
    context.strokeStyle = look.ink ?? "#1d1c1a";
    context.beginPath();
  }

  /** @param {number} stroke @param {number} from @param {number} to */
  _stroke(stroke, from, to) {
    const { context, lines, look } = this;
    const first = lines.offsets[stroke];
    if (from === first && stroke && look.travel) this._travel(first);
    const own = this._colour(stroke);
    if (own) {
      context.stroke();
      context.beginPath();
      context.strokeStyle = own;
    }
    this._trace(Math.max(first, from - 1), to);
    if (own) {
      context.stroke();
      this._pen();
    }
  }

  /** A colour of its own, if the stroke has one. @param {number} stroke */
  _colour(stroke) {
    const { lines, look } = this;
    if (look.red?.has(stroke)) return look.accent ?? RED;
    if (look.byOrder) return orderColour(stroke / Math.max(1, lines.offsets.length - 2));
    return look.inks?.[lines.layer?.[stroke] ?? 0];
  }

  /** @param {number} from @param {number} to */
  _trace(from, to) {
    const { context, scale, x, y } = this;
    const { points } = this.lines;
    context.moveTo(x + points[2 * from] * scale, y + points[2 * from + 1] * scale);
    if (to - from === 1) context.lineTo(x + points[2 * from] * scale + 0.01, y + points[2 * from + 1] * scale);
    for (let i = from + 1; i < to; i += 1) context.lineTo(x + points[2 * i] * scale, y + points[2 * i + 1] * scale);
  }

  /** @param {number} first the point that the pen goes to, lifted */
  _travel(first) {
    const { context, look } = this;
    context.stroke();
    context.save();
    context.beginPath();
    context.lineWidth = Math.max(0.6, Math.min(1, this.widthPx));
    context.globalAlpha = 0.55;
    context.strokeStyle = look.accent ?? RED;
    this._trace(first - 1, first + 1);
    context.stroke();
    context.restore();
    context.beginPath();
  }
}
