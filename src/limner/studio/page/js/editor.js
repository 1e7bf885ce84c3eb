// A photo and its landmarks go in; a picture where they are moved by mouse, touch or keys comes out, and their new places.

import { context, fitPixels, onResize, themeColour } from "./canvas.js";
import { h } from "./dom.js";
import { COUNT, moved, nameOf, nearest, PARTS, partOf } from "./landmarks.js";
import { fit, toPicture, toScreen, zoomed } from "./viewport.js";

/** @typedef {import("./landmarks.js").Point} Point */
/** @typedef {{width: number, height: number, url: string}} Picture */
/** @typedef {{changed: (points: Point[]) => void, picked: (text: string) => void, undo: () => void, redo: () => void}} Tell */

const REACH_PX = 18;
const MOST_ZOOM = 24;
const LOUPE = { radius: 70, zoom: 2.5 };
/** Colours that stand out on skin, hair and paper, by region. */
export const COLOURS = new Map([["jaw", "#ffd166"], ["brow", "#7bdff2"], ["nose", "#f7aef8"], ["eye", "#b8f2a0"], ["mouth", "#ff8fa3"]]);

const STEPS = new Map([["ArrowLeft", [-1, 0]], ["ArrowRight", [1, 0]], ["ArrowUp", [0, -1]], ["ArrowDown", [0, 1]]]);

/** The editor: one landmark is picked at a time. */
export class Editor {
  /** @param {Picture} picture @param {Tell} tell */
  constructor(picture, tell) {
    this.picture = picture;
    this.tell = tell;
    this.canvas = h("canvas");
    this.element = h("div", {
      class: "editor", tabindex: "0", role: "application", "aria-roledescription": "landmark editor",
      "aria-label": "Photo with landmarks", "aria-describedby": "editor-help",
    }, this.canvas);
    this.image = new Image();
    this.image.src = picture.url;
    this.image.decode().then(() => this.render(), () => {});
    /** @type {Point[]} */
    this.points = [];
    /** @type {Point[] | null} shown in grey beside them, to compare */
    this.ghost = null;
    /** @type {Set<string>} */
    this.visible = new Set(COLOURS.keys());
    /** @type {(index: number) => boolean} */
    this.movable = ALL;
    this.regions = true;
    this.picked = -1;
    /** @type {{index: number, at: [number, number], moved: boolean} | null} */
    this.drag = null;
    /** @type {Map<number, [number, number]>} */
    this.fingers = new Map();
    this._listen();
    this.stop = onResize(this.element, () => this.render());
  }

  close() {
    this.stop();
  }

  /** @param {Point[]} points */
  show(points) {
    this.points = points;
    this.render();
  }

  /** The whole photo, or the face filling the view. */
  frame() {
    const { width, height } = this.canvas;
    if (!this.points.length) {
      this.view = fit(this.picture.width, this.picture.height, width, height, 0);
      return this.render();
    }
    const [xs, ys] = [this.points.map(([x]) => x), this.points.map(([, y]) => y)];
    const [left, top, right, bottom] = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
    const around = fit((right - left) * 1.35, (bottom - top) * 1.35, width, height, 0);
    this.view = { scale: around.scale, x: width / 2 - (around.scale * (left + right)) / 2, y: height / 2 - (around.scale * (top + bottom)) / 2 };
    return this.render();
  }

  /** @param {number} factor @param {[number, number]} [at] */
  zoom(factor, at = [this.canvas.width / 2, this.canvas.height / 2]) {
    if (!this.view) return;
    const least = fit(this.picture.width, this.picture.height, this.canvas.width, this.canvas.height, 0).scale * 0.5;
    this.view = zoomed(this.view, factor, at, least, MOST_ZOOM);
    this.render();
  }

  render() {
    if (!this.element.clientWidth) return;
    const resized = fitPixels(this.canvas);
    if (!this.view || (resized && !this.drag)) {
      this.view = undefined;
      this.view = fit(this.picture.width, this.picture.height, this.canvas.width, this.canvas.height, 0);
      if (this.points.length) return this.frame();
    }
    const paint = context(this.canvas);
    const { scale, x, y } = this.view;
    paint.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.image.naturalWidth) paint.drawImage(this.image, x, y, scale * this.picture.width, scale * this.picture.height);
    if (this.ghost) this._curves(paint, this.ghost, "rgb(255 255 255 / 75%)");
    if (this.regions) this._curves(paint, this.points);
    this._dots(paint);
    if (this.drag && this.drag.index >= 0 && this.drag.moved) this._loupe(paint);
    return undefined;
  }

  get ratio() {
    return this.canvas.width / Math.max(1, this.element.clientWidth);
  }

  /** Where a landmark is on the screen [px of the window]. @param {number} index */
  screenOf(index) {
    const box = this.element.getBoundingClientRect();
    const [x, y] = toScreen(this.view ?? { scale: 1, x: 0, y: 0 }, this.points[index]);
    return [box.left + x / this.ratio, box.top + y / this.ratio];
  }

  /** @param {number} index */
  shown(index) {
    return this.visible.has(partOf(index).key);
  }

  /** @param {CanvasRenderingContext2D} paint @param {Point[]} points @param {string} [colour] */
  _curves(paint, points, colour) {
    if (points.length !== COUNT || !this.view) return;
    paint.lineWidth = 1.5 * this.ratio;
    paint.lineJoin = "round";
    for (const part of PARTS) {
      if (!this.visible.has(part.key)) continue;
      paint.beginPath();
      for (let i = part.first; i <= part.last; i += 1) paint.lineTo(...toScreen(this.view, points[i]));
      if (part.closed) paint.closePath();
      paint.strokeStyle = colour ?? COLOURS.get(part.key) ?? "#fff";
      if (colour) paint.setLineDash([4 * this.ratio, 4 * this.ratio]);
      paint.stroke();
      paint.setLineDash([]);
      if (part.closed && !colour) {
        paint.globalAlpha = 0.14;
        paint.fillStyle = paint.strokeStyle;
        paint.fill();
        paint.globalAlpha = 1;
      }
    }
  }

  /** @param {CanvasRenderingContext2D} paint */
  _dots(paint) {
    const { view, ratio } = this;
    if (!view) return;
    this.points.forEach((point, index) => {
      if (!this.shown(index)) return;
      const [x, y] = toScreen(view, point);
      const big = !this.movable(index) ? 1.5 : index === this.picked ? 7 : this.movable === ALL ? 3.4 : 9;
      paint.beginPath();
      paint.arc(x, y, big * ratio, 0, 7);
      paint.fillStyle = index === this.picked ? themeColour("--accent") : COLOURS.get(partOf(index).key) ?? "#fff";
      paint.fill();
      paint.lineWidth = (index === this.picked ? 2.5 : 1) * ratio;
      paint.strokeStyle = index === this.picked ? "#fff" : "rgb(0 0 0 / 70%)";
      paint.stroke();
    });
  }

  /** What is under the finger, larger, beside it. @param {CanvasRenderingContext2D} paint */
  _loupe(paint) {
    const { view, ratio } = this;
    if (!view || !this.drag) return;
    const point = this.points[this.drag.index];
    const [x] = toScreen(view, point);
    const radius = LOUPE.radius * ratio;
    const cx = x < this.canvas.width / 2 ? this.canvas.width - radius * 1.2 : radius * 1.2;
    const scale = view.scale * LOUPE.zoom;
    paint.save();
    paint.beginPath();
    paint.arc(cx, radius * 1.2, radius, 0, 7);
    paint.fillStyle = "#111";
    paint.fill();
    paint.clip();
    paint.drawImage(this.image, cx - scale * point[0], radius * 1.2 - scale * point[1], scale * this.picture.width, scale * this.picture.height);
    paint.restore();
    paint.lineWidth = 3 * ratio;
    paint.strokeStyle = "#fff";
    paint.stroke();
    paint.beginPath();
    paint.arc(cx, radius * 1.2, 4 * ratio, 0, 7);
    paint.strokeStyle = themeColour("--accent");
    paint.stroke();
  }

  _listen() {
    const { element } = this;
    element.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => this._down(event));
    element.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => this._move(event));
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (/** @type {PointerEvent} */ event) => this._up(event));
    element.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), this._place(event));
    }, { passive: false });
    element.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => this._key(event));
  }

  /** @param {MouseEvent} event @returns {[number, number]} */
  _place(event) {
    const box = this.element.getBoundingClientRect();
    return [(event.clientX - box.left) * this.ratio, (event.clientY - box.top) * this.ratio];
  }

  /** @param {PointerEvent} event */
  _down(event) {
    this.element.setPointerCapture(event.pointerId);
    const at = this._place(event);
    this.fingers.set(event.pointerId, at);
    if (!this.view) return;
    const screen = this.points.map((point) => toScreen(/** @type {any} */ (this.view), point));
    const index = nearest(screen, at, REACH_PX * this.ratio, (i) => this.shown(i) && this.movable(i));
    this.drag = this.fingers.size > 1 ? null : { index, at, moved: false };
    if (index >= 0) this.pick(index);
  }

  /** @param {PointerEvent} event */
  _move(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before || !this.view) return;
    const at = this._place(event);
    this.fingers.set(event.pointerId, at);
    if (this.fingers.size === 2) return this._pinch(event.pointerId, before, at);
    if (!this.drag) return;
    this.drag.moved ||= Math.hypot(at[0] - this.drag.at[0], at[1] - this.drag.at[1]) > 2 * this.ratio;
    if (!this.drag.moved) return;
    if (this.drag.index < 0) {
      this.view = { ...this.view, x: this.view.x + at[0] - before[0], y: this.view.y + at[1] - before[1] };
    } else {
      const [[px, py], [bx, by]] = [toPicture(this.view, at), toPicture(this.view, before)];
      const [x, y] = this.points[this.drag.index];
      this.points = this.moving(this.drag.index, [x + px - bx, y + py - by]);
    }
    this.render();
  }

  /** @param {number} finger @param {[number, number]} before @param {[number, number]} at */
  _pinch(finger, before, at) {
    const other = [...this.fingers].find(([id]) => id !== finger)?.[1] ?? at;
    const far = (/** @type {[number, number]} */ a) => Math.max(1, Math.hypot(a[0] - other[0], a[1] - other[1]));
    this.zoom(far(at) / far(before), [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2]);
  }

  /** @param {PointerEvent} event */
  _up(event) {
    this.fingers.delete(event.pointerId);
    const done = this.drag?.moved && this.drag.index >= 0;
    this.drag = null;
    if (done) this.tell.changed(this.points);
    this.render();
  }

  /** The points with one moved; whoever places a template puts another rule here. @param {number} index @param {Point} to */
  moving(index, to) {
    return moved(this.points, index, to, this.picture);
  }

  /** @param {number} index */
  pick(index) {
    this.picked = index;
    const [x, y] = this.points[index];
    this.tell.picked(`${index + 1} of ${COUNT}: ${nameOf(index)}, at ${Math.round(x)}, ${Math.round(y)}`);
    this.render();
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    const step = STEPS.get(event.key);
    const command = event.ctrlKey || event.metaKey;
    if (command && event.key.toLowerCase() === "z") (event.shiftKey ? this.tell.redo : this.tell.undo)();
    else if (command && event.key.toLowerCase() === "y") this.tell.redo();
    else if (command || event.altKey) return;
    else if (step) this._nudge(step, event.shiftKey ? 10 : 1);
    else if (event.key === "." || event.key === "PageDown") this._next(1);
    else if (event.key === "," || event.key === "PageUp") this._next(-1);
    else if (event.key === "+" || event.key === "=") this.zoom(1.25);
    else if (event.key === "-") this.zoom(0.8);
    else if (event.key === "0") this.frame();
    else return;
    event.preventDefault();
  }

  /** @param {number[]} step @param {number} by */
  _nudge([dx, dy], by) {
    if (this.picked < 0) return this._next(1);
    const [x, y] = this.points[this.picked];
    const points = this.moving(this.picked, [x + dx * by, y + dy * by]);
    this.show(points);
    this.tell.changed(points);
    this.pick(this.picked);
    return undefined;
  }

  /** @param {number} way */
  _next(way) {
    if (!this.points.length) return;
    let index = this.picked;
    for (let tried = 0; tried < COUNT; tried += 1) {
      index = (index + way + COUNT) % COUNT;
      if (this.shown(index) && this.movable(index)) return this.pick(index);
    }
  }
}

/** Every landmark may be moved. */
export const ALL = () => true;
