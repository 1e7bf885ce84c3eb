// An arm, a plan and joint positions go in; the arm over its sheet, seen from above and true to scale, comes out.

import { context, fitPixels, onResize, themeColour } from "./canvas.js";
import { h } from "./dom.js";
import { NOTHING, RED } from "./ink.js";
import { apply, frames, place } from "./kinematics.js";

/** @typedef {import("./kinematics.js").Joint} Joint */
/** @typedef {{scale: number, x: number, y: number}} Map pixels of the canvas for metres, y turned up */

const ROOM_M = 0.12;

/** The arm from above. */
export class AboveView {
  constructor() {
    this.back = h("canvas", { "aria-hidden": "true" });
    this.front = h("canvas", { "aria-hidden": "true" });
    this.element = h("div", { class: "above", role: "img", "aria-label": "The arm drawing, from above", hidden: true }, this.back, this.front);
    /** @type {any} */
    this.robot = null;
    this.lines = NOTHING;
    this.red = new Set();
    this.drawn = 0;
    this.ink = 0;
    /** @type {number[]} */
    this.q = [];
    this.stop = onResize(this.element, () => this._fit());
    this.recolour = () => this._fit();
    addEventListener("limner-theme", this.recolour);
  }

  close() {
    this.stop();
    removeEventListener("limner-theme", this.recolour);
  }

  /** @param {any} robot @param {any} plan @param {import("./ink.js").Lines} lines @param {import("./ink.js").Page} page */
  setPlan(robot, plan, lines, page) {
    Object.assign(this, { robot, plan, lines, page });
    this.paper = plan.base_from_paper.flat();
    this.red = new Set(plan.unreachable);
    this.radii = new Map(robot.links.map((/** @type {any} */ link) => [link.name, Math.max(0.02, ...link.shapes.map((/** @type {any} */ shape) => shape.radius))]));
    this._fit();
  }

  /** @param {number[]} q @param {number} ink points drawn */
  show(q, ink) {
    this.q = q;
    this.ink = ink;
    if (!this.map) return this._fit();
    if (ink < this.drawn) this._sheet();
    this._ink();
    this._arm();
    return undefined;
  }

  /** A place of the sheet [mm, y down] on the canvas. @param {number} x @param {number} y @returns {[number, number]} */
  _onSheet(x, y) {
    return this._pixel(apply(this.paper ?? [], [x / 1000, (this.page.height_mm - y) / 1000, 0]));
  }

  /** @param {number[]} point [m] @returns {[number, number]} */
  _pixel([x, y]) {
    const { scale, x: left, y: top } = this.map ?? { scale: 1, x: 0, y: 0 };
    return [left + scale * x, top - scale * y];
  }

  _corners() {
    const { width_mm: w, height_mm: h0 } = this.page;
    return [[0, 0], [w, 0], [w, h0], [0, h0]].map(([x, y]) => apply(this.paper ?? [], [x / 1000, y / 1000, 0]));
  }

  /** Base, sheet and the arm at some of its positions fill the view. */
  _fit() {
    if (!this.element.clientWidth || !this.robot || !this.plan) return;
    fitPixels(this.back);
    fitPixels(this.front);
    const { width, height } = this.front;
    const seen = [[0, 0, 0], ...this._corners()];
    const { joints, dof, times = [], line } = this.plan;
    if (!joints && this.q.length) seen.push(...this._chain(this.q).map(({ at }) => at));
    // Only while it draws: before and after the arm may stand anywhere.
    for (let i = 0; i < times.length; i += Math.max(1, times.length >> 6)) if (line[i] >= 0) seen.push(...this._chain(Array.from(joints.slice(i * dof, (i + 1) * dof))).map(({ at }) => at));
    const [xs, ys] = [seen.map(([x]) => x), seen.map(([, y]) => y)];
    const [left, right, low, high] = [Math.min(...xs) - ROOM_M, Math.max(...xs) + ROOM_M, Math.min(...ys) - ROOM_M, Math.max(...ys) + ROOM_M];
    const scale = Math.min(width / (right - left), height / (high - low));
    this.map = { scale, x: (width - scale * (left + right)) / 2, y: (height + scale * (low + high)) / 2 };
    this._sheet();
    this._ink();
    if (this.q.length) this._arm();
  }

  /** @param {number[]} q */
  _chain(q) {
    const positions = Object.fromEntries(this.plan.joints_named.map((/** @type {string} */ name, /** @type {number} */ i) => [name, q[i]]));
    const found = frames(this.robot.joints, positions);
    return found.map((matrix, i) => ({ at: place(matrix), link: i ? this.robot.joints[i - 1].child : this.robot.base }));
  }

  _sheet() {
    const paint = context(this.back);
    paint.clearRect(0, 0, this.back.width, this.back.height);
    paint.beginPath();
    this._corners().forEach((corner) => paint.lineTo(...this._pixel(corner)));
    paint.closePath();
    paint.save();
    paint.shadowColor = "rgb(40 30 10 / 25%)";
    paint.shadowBlur = 18;
    paint.fillStyle = themeColour("--sheet");
    paint.fill();
    paint.restore();
    this.drawn = 0;
  }

  _ink() {
    const paint = context(this.back);
    const { offsets, points, unit } = this.lines;
    paint.beginPath();
    paint.strokeStyle = themeColour("--sheet-ink");
    paint.lineWidth = Math.max(0.8, (this.page.pen_mm / 1000) * (this.map?.scale ?? 1));
    let stroke = 0;
    while (stroke < offsets.length - 2 && offsets[stroke + 1] <= this.drawn) stroke += 1;
    for (let i = Math.max(0, this.drawn - 1); i < this.ink; i += 1) {
      while (stroke < offsets.length - 2 && i >= offsets[stroke + 1]) stroke += 1;
      if (i === offsets[stroke] && this.red.size) {
        paint.stroke();
        paint.beginPath();
        paint.strokeStyle = this.red.has(stroke) ? RED : themeColour("--sheet-ink");
      }
      const at = this._onSheet(points[2 * i] * unit, points[2 * i + 1] * unit);
      if (i === offsets[stroke] || i === this.drawn - 1) paint.moveTo(...at);
      else paint.lineTo(...at);
    }
    paint.stroke();
    this.drawn = this.ink;
  }

  _arm() {
    const paint = context(this.front);
    const chain = this._chain(this.q);
    const scale = this.map?.scale ?? 1;
    paint.clearRect(0, 0, this.front.width, this.front.height);
    paint.lineCap = "round";
    const dark = themeColour("--ink");
    for (const [colour, more] of [[dark, 3], [themeColour("--card"), 0]]) {
      for (let i = 1; i < chain.length; i += 1) {
        const radius = Math.min(0.06, this.radii?.get(chain[i - 1].link) ?? 0.03);
        paint.globalAlpha = more ? 0.5 : 0.82;
        paint.beginPath();
        paint.moveTo(...this._pixel(chain[i - 1].at));
        paint.lineTo(...this._pixel(chain[i].at));
        paint.lineWidth = Math.max(4, 1.3 * radius * scale) + /** @type {number} */ (more);
        paint.strokeStyle = /** @type {string} */ (colour);
        paint.stroke();
      }
    }
    paint.globalAlpha = 1;
    chain.forEach(({ at }, i) => this._dot(paint, at, i === chain.length - 1 ? themeColour("--accent") : dark, i === chain.length - 1 ? 5 : 3));
  }

  /** @param {CanvasRenderingContext2D} paint @param {number[]} at @param {string} colour @param {number} radius */
  _dot(paint, at, colour, radius) {
    paint.beginPath();
    paint.arc(...this._pixel(at), radius, 0, 7);
    paint.fillStyle = colour;
    paint.fill();
  }
}
