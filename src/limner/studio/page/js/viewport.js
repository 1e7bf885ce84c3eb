// A picture and the room for it go in; a map from its coordinates to the screen comes out, to zoom and to pan.

/** @typedef {{scale: number, x: number, y: number}} View screen = scale * picture + (x, y) */

/**
 * The whole picture, centred, with some room around it.
 * @param {number} width of the picture
 * @param {number} height
 * @param {number} roomWidth
 * @param {number} roomHeight
 * @param {number} [margin] on each side of the screen
 * @returns {View}
 */
export function fit(width, height, roomWidth, roomHeight, margin = 0) {
  const scale = Math.max(1e-6, Math.min((roomWidth - 2 * margin) / width, (roomHeight - 2 * margin) / height));
  return { scale, x: (roomWidth - scale * width) / 2, y: (roomHeight - scale * height) / 2 };
}

/**
 * Larger by a factor, what is under a place of the screen staying there.
 * @param {View} view
 * @param {number} factor
 * @param {[number, number]} at
 * @param {number} least
 * @param {number} most
 * @returns {View}
 */
export function zoomed(view, factor, at, least, most) {
  const scale = Math.min(Math.max(view.scale * factor, least), most);
  const by = scale / view.scale;
  return { scale, x: at[0] - by * (at[0] - view.x), y: at[1] - by * (at[1] - view.y) };
}

/**
 * @param {View} view
 * @param {[number, number]} place in the picture
 * @returns {[number, number]}
 */
export function toScreen(view, [x, y]) {
  return [view.scale * x + view.x, view.scale * y + view.y];
}

/**
 * @param {View} view
 * @param {[number, number]} place on the screen
 * @returns {[number, number]}
 */
export function toPicture(view, [x, y]) {
  return [(x - view.x) / view.scale, (y - view.y) / view.scale];
}
