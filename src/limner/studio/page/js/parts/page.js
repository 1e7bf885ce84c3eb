// The paper, its margin and the pen: a section of controls comes out.

import { h } from "../dom.js";

/** @param {import("../app.js").App} app */
export function pagePart(app) {
  const { pages } = app.options;
  const size = h("select", { id: "page-size", onchange: () => say() }, pages.map((/** @type {any} */ { name }) => h("option", { value: name }, name.toUpperCase())));
  const wide = h("input", { type: "checkbox", onchange: () => say() });
  const margin = number("page-margin", 0, 60, 1, "page.margin_mm", app);
  const pen = number("pen-width", 0.1, 3, 0.1, "page.pen_mm", app);
  const say = () => app.change({ "page.size": size.value + (wide.checked ? ":landscape" : "") });
  const stop = app.store.watch(["settings"], () => {
    const [name, turned] = String(app.value("page.size")).split(":");
    size.value = name;
    wide.checked = turned === "landscape";
    margin.value = app.value("page.margin_mm");
    pen.value = app.value("page.pen_mm");
  });
  const row = (/** @type {string} */ id, /** @type {string} */ name, /** @type {any} */ input, /** @type {string} */ unit) =>
    h("div", { class: "row apart" }, h("label", { for: id }, name), h("span", { class: "row" }, input, unit && h("span", { class: "quiet small" }, unit)));
  const element = h("section", { "aria-labelledby": "page-title" }, h("h2", { id: "page-title" }, "Paper and pen"),
    row("page-size", "Paper", size, ""), h("label", { class: "check" }, wide, "Landscape"), row("page-margin", "Margin", margin, "mm"), row("pen-width", "Pen", pen, "mm"));
  return { element, close: stop };
}

/** @param {string} id @param {number} min @param {number} max @param {number} step @param {string} path @param {import("../app.js").App} app */
function number(id, min, max, step, path, app) {
  const input = h("input", { id, type: "number", min, max, step, onchange: () => input.checkValidity() && input.value && app.change({ [path]: Number(input.value) }) });
  return input;
}
