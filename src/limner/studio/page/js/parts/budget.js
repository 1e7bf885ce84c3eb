// How long the machine may draw, or how many points there may be: the first thing a drawing is adjusted by.

import { h, put } from "../dom.js";
import { count } from "../format.js";
import { fromShare, toShare } from "../settings.js";

/** @typedef {import("../app.js").App} App */

const KINDS = {
  minutes: { path: "select.minutes", low: 0.25, high: 30, start: 3, words: (/** @type {number} */ n) => `${n < 2 ? n.toFixed(2).replace(/0$/, "") : n.toFixed(n < 10 ? 1 : 0)} min` },
  points: { path: "select.points", low: 60, high: 12000, start: 1000, words: (/** @type {number} */ n) => `${count(n)} points` },
};
/** @typedef {keyof typeof KINDS | "all"} Kind */

/** @param {App} app @returns {Kind} */
function kindOf(app) {
  if ((app.value("select.minutes") ?? null) !== null) return "minutes";
  return (app.value("select.points") ?? null) === null ? "all" : "points";
}

/** @param {App} app */
export function budget(app) {
  const machine = h("select", { id: "machine", onchange: () => app.change({ machine: machine.value }) },
    app.options.machines.map((/** @type {any} */ { name }) => h("option", { value: name }, name)));
  const said = h("output", { for: "budget" });
  const slider = h("input", { id: "budget", type: "range", min: 0, max: 1, step: 0.005, oninput: () => slide() });
  const ends = h("div", { class: "ends", "aria-hidden": "true" });
  const field = h("div", { class: "field" }, h("div", { class: "head" }, h("label", { for: "budget" }, "At most"), said), slider, ends);
  const buttons = [["all", "Everything"], ["minutes", "Minutes"], ["points", "Points"]].map(([kind, name]) =>
    h("button", { type: "button", "data-kind": kind, onclick: () => take(/** @type {Kind} */ (kind)) }, name));

  const take = (/** @type {Kind} */ kind, /** @type {number} */ value = kind === "all" ? 0 : KINDS[kind].start) => {
    const own = kind === "all" ? {} : { [KINDS[kind].path]: value };
    app.change({ "select.minutes": null, "select.points": null, ...own });
  };
  const slide = () => {
    const kind = kindOf(app);
    if (kind === "all") return;
    const { low, high } = KINDS[kind];
    const value = fromShare(Number(slider.value), low, high);
    take(kind, kind === "points" ? Math.round(value / 10) * 10 : Math.round(value * 20) / 20);
  };
  const presets = app.options.presets.map((/** @type {any} */ preset) =>
    h("button", { type: "button", title: preset.help, onclick: () => app.change(preset.settings) }, preset.label));
  const stop = app.store.watch(["settings"], () => {
    const kind = kindOf(app);
    buttons.forEach((button) => put(button, "aria-pressed", String(button.dataset.kind === kind)));
    machine.value = app.value("machine");
    field.hidden = kind === "all";
    presets.forEach((/** @type {HTMLElement} */ button, /** @type {number} */ i) => put(button, "aria-pressed", String(isSet(app, app.options.presets[i].settings))));
    if (kind === "all") return;
    const { path, low, high, words } = KINDS[kind];
    said.textContent = words(app.value(path));
    put(slider, "aria-valuetext", words(app.value(path)));
    if (document.activeElement !== slider) slider.value = String(toShare(app.value(path), low, high));
    ends.replaceChildren(h("span", {}, words(low)), h("span", {}, words(high)));
  });
  const element = h("section", { "aria-labelledby": "budget-title" }, h("h2", { id: "budget-title" }, "How much"),
    h("div", { class: "segmented", role: "group", "aria-label": "Budget" }, buttons), field,
    h("div", { class: "row apart" }, h("label", { for: "machine" }, "Drawn by"), machine),
    h("div", { class: "chips", role: "group", "aria-label": "Presets" }, presets));
  return { element, close: stop };
}

/** @param {App} app @param {Record<string, any>} settings */
function isSet(app, settings) {
  return Object.entries(settings).every(([path, value]) => (app.value(path) ?? null) === value);
}
