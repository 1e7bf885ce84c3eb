// The description of a setting goes in; a control for it, with its unit, limits and help, comes out.

import { h, put } from "./dom.js";
import { plain } from "./format.js";
import { fromShare, limits, parse, toShare, words } from "./settings.js";

/** @typedef {import("./settings.js").Setting} Setting */
/** @typedef {{element: HTMLElement, show: (value: any, changed: boolean) => void}} Control */
/** @typedef {(path: string, value: any) => void} Change value undefined: back to the default */

let made = 0;

/** @param {Setting} setting @param {Change} change @returns {Control} */
export function control(setting, change) {
  const id = `setting-${(made += 1)}`;
  const say = (/** @type {any} */ value) => change(setting.path, value);
  const field = setting.choices.length ? choice(setting, id, say) : setting.type === "bool" ? tick(setting, id, say) : entry(setting, id, say);
  const back = h("button", { type: "button", class: "plain back", hidden: true, onclick: () => say(undefined), "aria-label": `Reset ${setting.path}` }, "reset");
  const name = setting.path.split(".").pop() ?? setting.path;
  const element = h("div", { class: "setting", "data-path": setting.path },
    h("div", { class: "head" }, h("label", { for: id, title: setting.path }, words(name)), back),
    h("div", { class: "value" }, field.parts), h("p", { id: `${id}-help` }, [setting.help, limits(setting)].filter(Boolean).join(" · ")), field.error);
  put(field.input, "aria-describedby", `${id}-help`);
  return {
    element,
    show: (value, changed) => {
      element.classList.toggle("changed", changed);
      back.hidden = !changed;
      field.show(value);
    },
  };
}

/** @param {Setting} setting @param {string} id @param {(value: any) => void} say */
function choice(setting, id, say) {
  const input = h("select", { id, onchange: () => say(input.value) }, setting.choices.map((name) => h("option", { value: name }, name)));
  return { input, parts: [input], error: null, show: (/** @type {any} */ value) => (input.value = value) };
}

/** @param {Setting} setting @param {string} id @param {(value: any) => void} say */
function tick(setting, id, say) {
  const input = h("input", { id, type: "checkbox", onchange: () => say(input.checked) });
  return { input, parts: [input], error: null, show: (/** @type {any} */ value) => (input.checked = Boolean(value)) };
}

/** A text or a number; a number with both limits has a slider too. @param {Setting} setting @param {string} id @param {(value: any) => void} say */
function entry(setting, id, say) {
  const error = h("p", { class: "wrong small", role: "alert" });
  const text = setting.type === "text";
  const enter = () => {
    const read = parse(setting, input.value);
    error.textContent = read.error ?? "";
    put(input, "aria-invalid", read.error && "true");
    if (!read.error) say(read.value);
  };
  const input = h("input", { id, type: "text", inputmode: text ? null : "decimal", placeholder: setting.type.endsWith("?") ? "auto" : null, onchange: enter, autocomplete: "off", spellcheck: "false" });
  const slider = text || setting.low === null || setting.high === null ? null : slide(setting, say);
  const show = (/** @type {any} */ value) => {
    if (document.activeElement !== input) input.value = value === null || value === undefined ? "" : text ? value : plain(value);
    slider?.show(value);
    error.textContent = "";
  };
  return { input, parts: slider ? [slider.input, input] : [input], error, show };
}

/** @param {Setting} setting @param {(value: any) => void} say */
function slide(setting, say) {
  const [low, high] = [/** @type {number} */ (setting.low), /** @type {number} */ (setting.high)];
  const whole = setting.type.startsWith("int");
  const move = () => {
    const value = fromShare(Number(input.value), low, high);
    say(whole ? Math.round(value) : Number(value.toPrecision(3)));
  };
  const input = h("input", { type: "range", min: "0", max: "1", step: "any", "aria-label": setting.path, oninput: move });
  return { input, show: (/** @type {any} */ value) => (input.value = String(toShare(value ?? setting.default ?? low, low, high))) };
}
