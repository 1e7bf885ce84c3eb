// Descriptions of settings go in; groups, texts and checked values for controls come out.

/**
 * One setting as the server describes it.
 * @typedef {{path: string, type: string, default: any, low: number | null, high: number | null, unit: string, choices: string[], help: string}} Setting
 */
/** @typedef {{name: string, path: string, settings: Setting[], groups: Group[]}} Group */

/**
 * The settings as a tree of groups, in the order they come.
 * @param {Setting[]} settings
 * @returns {Group}
 */
export function tree(settings) {
  /** @type {Group} */
  const root = { name: "", path: "", settings: [], groups: [] };
  for (const setting of settings) {
    const names = setting.path.split(".");
    let here = root;
    names.slice(0, -1).forEach((name, i) => {
      const path = names.slice(0, i + 1).join(".");
      let next = here.groups.find((group) => group.path === path);
      if (!next) here.groups.push((next = { name, path, settings: [], groups: [] }));
      here = next;
    });
    here.settings.push(setting);
  }
  return root;
}

/**
 * A name of the tree as words: hair_apart is "hair apart", low_px "low".
 * @param {string} name
 */
export function words(name) {
  const units = ["px", "mm", "deg", "ms", "min", "hz"];
  const parts = name.split("_");
  if (parts.length > 1 && units.includes(parts[parts.length - 1])) parts.pop();
  return parts.join(" ");
}

/**
 * What may be entered, in words.
 * @param {Setting} setting
 */
export function limits({ low, high, unit }) {
  const range = low !== null && high !== null ? `${low} to ${high}` : low !== null ? `at least ${low}` : high !== null ? `at most ${high}` : "";
  return [range, unit].filter(Boolean).join(" ");
}

/**
 * The value a text stands for.
 * @param {Setting} setting
 * @param {string} text
 * @returns {{value?: any, error?: string}} no value for a text that takes the setting back
 */
export function parse(setting, text) {
  const wanted = text.trim();
  if (setting.type === "text") return { value: text };
  if (setting.type.endsWith("?") && (wanted === "" || wanted === "auto")) return { value: null };
  if (wanted === "") return {};
  const value = Number(wanted);
  if (!Number.isFinite(value)) return { error: "a number, please" };
  if (setting.type.startsWith("int") && !Number.isInteger(value)) return { error: "a whole number, please" };
  if (setting.low !== null && value < setting.low) return { error: `at least ${setting.low}` };
  if (setting.high !== null && value > setting.high) return { error: `at most ${setting.high}` };
  return { value };
}

/**
 * A copy with one setting changed, or taken back for undefined and for its default.
 * @param {Record<string, any>} values
 * @param {string} path
 * @param {any} value
 * @param {any} [usual] its default
 */
export function changed(values, path, value, usual) {
  const { [path]: _, ...rest } = values;
  return value === undefined || value === usual ? rest : { ...rest, [path]: value };
}

/**
 * Those settings that a search finds: all words in path or help.
 * @param {Setting[]} settings
 * @param {string} text
 */
export function find(settings, text) {
  const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
  return settings.filter(({ path, help }) => {
    const about = `${path} ${words(path)} ${help}`.toLowerCase();
    return wanted.every((word) => about.includes(word));
  });
}

/**
 * A share of a slider's way as a value: even steps, or even factors where the range spans many sizes.
 * @param {number} share 0 to 1
 * @param {number} low
 * @param {number} high
 */
export function fromShare(share, low, high) {
  return low > 0 && high / low >= 20 ? low * (high / low) ** share : low + share * (high - low);
}

/**
 * @param {number} value
 * @param {number} low
 * @param {number} high
 */
export function toShare(value, low, high) {
  const share = low > 0 && high / low >= 20 ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.min(Math.max(share, 0), 1);
}
