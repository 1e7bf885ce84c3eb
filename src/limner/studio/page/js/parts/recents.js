// The drawings of this run go in; a strip of small sheets to go back to comes out.

import { h } from "../dom.js";
import { Sheet } from "../sheet.js";

/** @param {import("../app.js").App} app */
export function recentList(app) {
  const list = h("ul", { class: "recents" });
  const element = h("section", { class: "stack tight", hidden: true, "aria-label": "Drawings of this run" }, h("h2", { class: "small quiet" }, "Drawn since limner was started"), list);
  /** @type {Sheet[]} */
  let sheets = [];
  const clear = () => (sheets.forEach((sheet) => sheet.close()), (sheets = []));
  const stop = app.store.watch(["recents"], ({ recents }) => {
    clear();
    element.hidden = !recents.length;
    list.replaceChildren(...recents.map((/** @type {any} */ recent, /** @type {number} */ i) => {
      const sheet = new Sheet({ bare: true, label: `Drawing ${recents.length - i}` });
      sheets.push(sheet);
      sheet.show(recent.lines, recent.page);
      return h("li", {}, h("button", { type: "button", onclick: () => app.recall(recent) }, h("span", { class: "paper" }, sheet.element)));
    }));
  });
  return { element, close: () => (stop(), clear()) };
}
