// A sheet goes in; a drawing that draws itself on it, as an example, comes out.

import { A5, Sheet } from "./sheet.js";
import { pointCount } from "./ink.js";
import { calm } from "./motion.js";

const DRAWN_S = 14;
const SHOWN_S = 6;

/** @returns {Promise<import("./ink.js").Lines>} */
async function load() {
  const strokes = await (await fetch("img/specimen.json")).json();
  const offsets = new Uint32Array(strokes.length + 1);
  strokes.forEach((/** @type {number[]} */ stroke, /** @type {number} */ i) => (offsets[i + 1] = offsets[i] + stroke.length / 2));
  return { offsets, points: Int16Array.from(strokes.flat()), unit: 0.1 };
}

/**
 * @param {string} label
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function specimen(label) {
  const sheet = new Sheet({ label, bare: true });
  let running = true;
  load().then((lines) => {
    const total = pointCount(lines);
    sheet.show(lines, A5, calm() ? total : 0);
    const begun = performance.now();
    const step = (/** @type {number} */ now) => {
      if (!running) return;
      const second = ((now - begun) / 1000) % (DRAWN_S + SHOWN_S);
      sheet.showUntil(Math.min(total, Math.ceil((second / DRAWN_S) * total)));
      requestAnimationFrame(step);
    };
    if (!calm()) requestAnimationFrame(step);
  });
  return { element: sheet.element, close: () => ((running = false), sheet.close()) };
}
