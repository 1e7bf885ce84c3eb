// All settings go in; a panel that holds every one of them, in the groups of the tree, with a search, comes out.

import { control } from "../controls.js";
import { h } from "../dom.js";
import { find, tree, words } from "../settings.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../controls.js").Control} Control */

/** @param {App} app */
export function expert(app) {
  /** @type {Map<string, Control>} */
  const controls = new Map();
  const all = app.options.settings;
  const change = (/** @type {string} */ path, /** @type {any} */ value) => app.change({ [path]: value });
  const make = (/** @type {any} */ setting) => {
    const made = control(setting, change);
    controls.set(setting.path, made);
    made.show(app.value(setting.path), setting.path in app.state.settings);
    return made.element;
  };
  const results = h("div");
  const search = h("input", { type: "search", placeholder: "Search all settings", "aria-label": "Search all settings", oninput: () => look() });
  const groups = h("div", {}, folder(tree(all), make));
  const look = () => {
    const text = search.value.trim();
    groups.hidden = Boolean(text);
    controls.clear();
    groups.replaceChildren(...(text ? [] : folder(tree(all), make)));
    results.replaceChildren(...(text ? find(all, text).slice(0, 30).map(make) : []));
  };
  const element = h("details", {}, h("summary", {}, "Every setting"), h("div", { class: "stack tight" }, search, results, groups));
  const stop = app.store.watch(["settings"], ({ settings }) => controls.forEach((made, path) => made.show(app.value(path), path in settings)));
  return { element, close: stop };
}

/** A group's settings are made when it is opened: there are hundreds. @param {import("../settings.js").Group} group @param {(setting: any) => HTMLElement} make @returns {HTMLElement[]} */
function folder(group, make) {
  const inner = group.groups.map((each) => {
    const inside = h("div");
    const open = () => box.open && !inside.childElementCount && inside.append(...folder(each, make));
    const box = h("details", { ontoggle: open }, h("summary", {}, words(each.name)), inside);
    return box;
  });
  return [...group.settings.map(make), ...inner];
}
