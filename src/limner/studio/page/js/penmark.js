// Where the pen is goes in; its mark, and what it has drawn since the last sample, come out over the ink.

import { context } from "./canvas.js";

const RED = "#b8361c";

/** The pen over a sheet. Only the little that changed is cleared. */
export class PenMark {
  /** @param {import("./sheet.js").Sheet} sheet */
  constructor(sheet) {
    this.sheet = sheet;
    /** @type {[number, number, number, number] | null} */
    this.dirty = null;
  }

  /** @param {import("./timeline.js").Timeline} timeline @param {import("./timeline.js").PenState} pen */
  show(timeline, pen) {
    const { sheet } = this;
    const layer = sheet.over;
    if (!layer || !sheet.element.clientWidth) return;
    const paint = context(layer);
    if (this.dirty) paint.clearRect(...this.dirty);
    else paint.clearRect(0, 0, layer.width, layer.height);
    const ratio = layer.width / sheet.element.clientWidth;
    const { points, unit } = timeline;
    const [x0, y0] = sheet.pixel(points[2 * pen.sample] * unit, points[2 * pen.sample + 1] * unit);
    const [x, y] = sheet.pixel(pen.x, pen.y);
    paint.beginPath();
    paint.moveTo(x0, y0);
    paint.lineTo(x, y);
    paint.lineCap = "round";
    paint.lineWidth = pen.down ? sheet.ink.widthPx : ratio;
    paint.strokeStyle = pen.down ? sheet.ink.look.ink ?? "#000" : "rgb(184 54 28 / 60%)";
    paint.stroke();
    paint.beginPath();
    paint.arc(x, y, (pen.down ? 4 : 6) * ratio, 0, 7);
    paint.fillStyle = RED;
    paint.globalAlpha = pen.down ? 1 : 0.45;
    paint.fill();
    paint.globalAlpha = 1;
    const room = 8 * ratio + sheet.ink.widthPx;
    this.dirty = [Math.min(x0, x) - room, Math.min(y0, y) - room, Math.abs(x - x0) + 2 * room, Math.abs(y - y0) + 2 * room];
  }
}
