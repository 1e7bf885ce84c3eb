// A page and its strokes go in; the sheet of paper, true to scale, with margin and ink comes out in an element.

import { context, fitPixels, onResize, themeColour } from "./canvas.js";
import { h } from "./dom.js";
import { Ink, NOTHING, pointCount, RED } from "./ink.js";
import { fit } from "./viewport.js";

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {import("./ink.js").Page} Page */
/** @typedef {import("./ink.js").Look} Look */

/** @type {Page} */
export const A5 = { width_mm: 148, height_mm: 210, margin_mm: 10, pen_mm: 0.5 };

/** The sheet: three layers, of which only what changes is drawn. */
export class Sheet {
  /** @param {{label?: string, bare?: boolean, margin?: number}} [how] bare: the element itself is the paper */
  constructor({ label = "The drawing", bare = false, margin = 32 } = {}) {
    this.bare = bare;
    this.margin = bare ? 0 : margin;
    this.back = h("canvas", { "aria-hidden": "true" });
    this.front = h("canvas", { "aria-hidden": "true" });
    this.over = bare ? null : h("canvas", { "aria-hidden": "true" });
    this.element = h("div", { class: "sheet", role: "img", "aria-label": label }, this.back, this.front, this.over);
    this.ink = new Ink(context(this.front));
    this.page = A5;
    this.until = Infinity;
    /** Whether strokes that are not drawn yet are hinted at. */
    this.hint = false;
    this.stop = onResize(this.element, () => this.render());
    this.scheme = matchMedia("(prefers-color-scheme: dark)");
    this.recolour = () => this.render(true);
    this.scheme.addEventListener("change", this.recolour);
    addEventListener("limner-theme", this.recolour);
  }

  /** Ends what the sheet listens to. */
  close() {
    this.stop();
    this.scheme.removeEventListener("change", this.recolour);
    removeEventListener("limner-theme", this.recolour);
  }

  /** @param {string} text */
  describe(text) {
    this.element.setAttribute("aria-label", text);
  }

  /**
   * @param {Lines} lines
   * @param {Page} page
   * @param {number} [until] points that are shown
   */
  show(lines, page, until = Infinity) {
    this.ink.lines = lines;
    this.page = page;
    this.until = until;
    this.render(true);
  }

  /** An empty sheet. @param {Page} page */
  empty(page) {
    this.show(NOTHING, page);
  }

  /** @param {Look} look */
  setLook(look) {
    this.ink.look = look;
    this.render(true);
  }

  /**
   * Ink up to a number of points: more is added, less starts anew.
   * @param {number} until
   */
  showUntil(until) {
    this.until = until;
    if (until < this.ink.drawn) this._clearInk();
    this.ink.advance(Math.min(until, pointCount(this.ink.lines)));
  }

  /** @param {boolean} [all] even when the size is the same */
  render(all = false) {
    if (!this.element.clientWidth) return;
    const changed = fitPixels(this.front);
    if (!changed && !all) return;
    fitPixels(this.back);
    if (this.over) fitPixels(this.over);
    const { width, height } = this.front;
    const ratio = width / this.element.clientWidth;
    this.view = fit(this.page.width_mm, this.page.height_mm, width, height, this.margin * ratio);
    this._paper(ratio);
    this.ink.place(this.view.scale, this.view.x, this.view.y, this.page.pen_mm);
    this._clearInk();
    this.ink.advance(Math.min(this.until, pointCount(this.ink.lines)));
    this.element.dispatchEvent(new CustomEvent("rendered"));
  }

  /** Pixels of the canvas for a place on the page [mm], y down. @param {number} x @param {number} y */
  pixel(x, y) {
    const { scale, x: left, y: top } = this.view ?? { scale: 1, x: 0, y: 0 };
    return [left + scale * x, top + scale * y];
  }

  _clearInk() {
    this.ink.look = { ...this.ink.look, ink: themeColour("--sheet-ink"), accent: RED, inks: this.page.inks };
    this.ink.context.clearRect(0, 0, this.front.width, this.front.height);
    this.ink.drawn = 0;
  }

  /** @param {number} ratio pixels of the screen per pixel of the page's layout */
  _paper(ratio) {
    if (this.bare || !this.view) return;
    const paint = context(this.back);
    const { scale, x, y } = this.view;
    const { width_mm, height_mm, margin_mm } = this.page;
    paint.clearRect(0, 0, this.back.width, this.back.height);
    paint.save();
    paint.shadowColor = "rgb(40 30 10 / 22%)";
    paint.shadowBlur = 20 * ratio;
    paint.shadowOffsetY = 6 * ratio;
    paint.fillStyle = themeColour("--sheet");
    paint.fillRect(x, y, scale * width_mm, scale * height_mm);
    paint.restore();
    paint.strokeStyle = "rgb(120 100 60 / 20%)";
    paint.setLineDash([3 * ratio, 5 * ratio]);
    const edge = scale * margin_mm;
    if (margin_mm > 0) paint.strokeRect(x + edge, y + edge, scale * width_mm - 2 * edge, scale * height_mm - 2 * edge);
    paint.setLineDash([]);
    if (this.hint) this._hint(paint);
  }

  /** All strokes, faint. @param {CanvasRenderingContext2D} paint */
  _hint(paint) {
    if (!this.view) return;
    const all = new Ink(paint);
    all.lines = this.ink.lines;
    all.look = { ink: "rgb(90 80 60 / 22%)" };
    all.place(this.view.scale, this.view.x, this.view.y, this.page.pen_mm);
    all.advance(Infinity);
  }
}
