// A canvas element goes in; its size kept to the screen's pixels, and its drawing context, come out.

/**
 * Fits the canvas's pixels to the size it is shown at.
 * @param {HTMLCanvasElement} canvas
 * @returns {boolean} whether it changed, and is empty now
 */
export function fitPixels(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return false;
  canvas.width = width;
  canvas.height = height;
  return true;
}

/**
 * The context, kept in memory rather than on a graphics card: lines are many and small.
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
export function context(canvas) {
  const found = canvas.getContext("2d", { willReadFrequently: true });
  if (!found) throw new Error("this browser has no 2-D canvas");
  return found;
}

/**
 * Calls back when an element's size changes; at most once a frame.
 * @param {Element} element
 * @param {() => void} changed
 * @returns {() => void} stops it
 */
export function onResize(element, changed) {
  const observer = new ResizeObserver(() => requestAnimationFrame(changed));
  observer.observe(element);
  return () => observer.disconnect();
}

/**
 * A colour of the page's theme.
 * @param {string} name such as --accent
 */
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
