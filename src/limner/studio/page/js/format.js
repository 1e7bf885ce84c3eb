// Numbers go in, what a person reads comes out.

/**
 * A time such as "45 s", "2 min 05 s" or "1 h 10 min".
 * @param {number | null | undefined} seconds
 */
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
  return `${Math.floor(whole / 3600)} h ${String(Math.floor((whole % 3600) / 60)).padStart(2, "0")} min`;
}

/**
 * A clock such as 2:05.
 * @param {number} seconds
 */
export function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/**
 * A length in millimetres as millimetres or metres.
 * @param {number | null | undefined} mm
 */
export function length(mm) {
  if (mm === null || mm === undefined || !Number.isFinite(mm)) return "–";
  return mm < 1000 ? `${Math.round(mm)} mm` : `${(mm / 1000).toFixed(mm < 10000 ? 2 : 1)} m`;
}

/**
 * A number with as few digits as tell it apart.
 * @param {number} value
 */
export function plain(value) {
  return String(Number(value.toPrecision(4)));
}

/**
 * @param {number | null | undefined} value
 */
export function count(value) {
  return value === null || value === undefined ? "–" : Math.round(value).toLocaleString("en");
}

/**
 * A share as per cent.
 * @param {number | null | undefined} share
 */
export function percent(share) {
  return share === null || share === undefined || !Number.isFinite(share) ? "–" : `${Math.round(share * 100)} %`;
}

/**
 * A thing and how many: "1 stroke", "12 strokes".
 * @param {number} many
 * @param {string} one
 */
export function plural(many, one) {
  return `${count(many)} ${one}${many === 1 ? "" : "s"}`;
}

/**
 * An error of the server as a sentence: "photo: is an animation" is "The photo is an animation."
 * @param {string} text
 */
export function sentence(text) {
  const said = text.replace(/^photo: /, "the photo ");
  return said.charAt(0).toUpperCase() + said.slice(1) + (/[.!?]$/.test(said) ? "" : ".");
}
