// A simple slider's place goes in, the settings it stands for come out; and back.

/** @typedef {{path: string, stops?: [number, number][], steps?: string[]}} Target */
/** @typedef {{name: string, label: string, help: string, default: number, sets: Target[]}} Slider */

/**
 * @param {Slider} slider
 * @param {number} place 0 to 1
 * @returns {Record<string, any>} none of them at the slider's usual place
 */
export function settingsAt(slider, place) {
  return Object.fromEntries(slider.sets.map((target) => [target.path, valueAt(target, place)]));
}

/**
 * Where a slider stands for given settings: its first setting says.
 * @param {Slider} slider
 * @param {Record<string, any>} settings
 */
export function placeOf(slider, settings) {
  const [target] = slider.sets;
  const value = settings[target.path];
  if (value === undefined || value === null) return slider.default;
  if (target.steps) return Math.max(0, target.steps.indexOf(value)) / (target.steps.length - 1);
  const stops = target.stops ?? [];
  for (let i = 1; i < stops.length; i += 1) {
    const share = (value - stops[i - 1][1]) / (stops[i][1] - stops[i - 1][1]);
    if (share <= 1 && (share >= 0 || i === 1)) return clamp(stops[i - 1][0] + share * (stops[i][0] - stops[i - 1][0]));
  }
  return 1;
}

/** @param {Slider} slider */
export function stepOf(slider) {
  const steps = slider.sets[0].steps;
  return steps ? 1 / (steps.length - 1) : 0.01;
}

/**
 * What a slider says of its place.
 * @param {Slider} slider
 * @param {number} place
 */
export function wordsAt(slider, place) {
  const value = slider.sets[0].steps ? String(valueAt(slider.sets[0], place)) : "";
  if (value) return value;
  return Math.abs(place - slider.default) < 0.005 ? "as usual" : place > slider.default ? "more" : "less";
}

/** @param {Target} target @param {number} place */
function valueAt({ stops, steps }, place) {
  if (steps) return steps[Math.round(place * (steps.length - 1))];
  const points = stops ?? [];
  const i = Math.max(1, points.findIndex(([at]) => at >= place));
  const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
  return Number((y0 + ((place - x0) / (x1 - x0)) * (y1 - y0)).toPrecision(5));
}

/** @param {number} share */
function clamp(share) {
  return Math.min(Math.max(share, 0), 1);
}
