// The fourth screen: what the drawing may cost, a few sliders, presets, the page, and every setting; the sheet shows it at once.

import { h, put } from "../dom.js";
import { duration, sentence } from "../format.js";
import { notes } from "../parts/notes.js";
import { budget } from "../parts/budget.js";
import { expert } from "../parts/expert.js";
import { figures } from "../parts/figures.js";
import { pagePart } from "../parts/page.js";
import { Sheet } from "../sheet.js";
import { placeOf, settingsAt, stepOf, wordsAt } from "../sliders.js";

/** @typedef {import("../app.js").App} App */

/** @param {App} app */
export function adjustScreen(app) {
  const sheet = new Sheet({ label: "The drawing on its page" });
  const busy = h("div", { class: "busy" }, h("span", { class: "spinner" }));
  const trouble = h("div", { class: "note bad", role: "alert", hidden: true });
  const under = h("div", { class: "under" });
  const view = h("div", { class: "view" }, sheet.element, busy, h("div", { class: "overlay" }, trouble, notes(app)));
  const parts = [budget(app), simple(app), styles(app), pagePart(app), expert(app), foot(app)];
  const [costs, sliders, ways, page, every, end] = parts;
  const panel = h("div", { class: "panel" },
    h("h1", { class: "out-of-sight" }, "Adjust the drawing"), costs.element, sliders.element, ways.element, page.element,
    h("section", {}, every.element), end.element);
  const stop = app.store.watch(["preview", "drawing", "drawingError"], ({ preview, drawing, drawingError }) => {
    busy.classList.toggle("on", drawing);
    trouble.hidden = !drawingError;
    trouble.textContent = sentence(drawingError);
    if (!preview || preview.lines === sheet.ink.lines) return;
    sheet.show(preview.lines, preview.page);
    sheet.describe(`The drawing: ${preview.report.strokes} strokes, ${duration(preview.report.seconds)}`);
    under.replaceChildren(figures(preview.report));
  });
  const element = h("div", { class: "split screen" }, h("div", { class: "stage" }, view, under), panel);
  return { element, close: () => (stop(), parts.forEach((part) => part.close()), sheet.close()) };
}

/** The simple sliders. @param {App} app */
function simple(app) {
  const rows = app.options.sliders.map((/** @type {any} */ slider) => {
    const id = `slider-${slider.name}`;
    const said = h("output", { for: id });
    const input = h("input", { id, type: "range", min: 0, max: 1, step: stepOf(slider), oninput: () => move(), "aria-describedby": `${id}-help` });
    const move = () => {
      const place = Number(input.value);
      const usual = Math.abs(place - slider.default) < 0.005;
      app.change(usual ? Object.fromEntries(slider.sets.map((/** @type {any} */ { path }) => [path, undefined])) : settingsAt(slider, place));
    };
    const show = (/** @type {any} */ settings) => {
      const place = placeOf(slider, settings);
      if (document.activeElement !== input) input.value = String(place);
      said.textContent = wordsAt(slider, place);
      put(input, "aria-valuetext", wordsAt(slider, place));
    };
    const element = h("div", { class: "field" }, h("div", { class: "head" }, h("label", { for: id }, slider.label), said), input, h("span", { class: "out-of-sight", id: `${id}-help` }, slider.help));
    return { element, show };
  });
  const close = app.store.watch(["settings"], ({ settings }) => rows.forEach((/** @type {any} */ row) => row.show(settings)));
  return { element: h("section", { "aria-labelledby": "lines-title" }, h("h2", { id: "lines-title" }, "Lines"), rows.map((/** @type {any} */ row) => row.element)), close };
}

/** Ways of drawing. @param {App} app */
function styles(app) {
  const buttons = app.options.styles.map((/** @type {any} */ { name, label, help }) =>
    h("button", { type: "button", title: help, "data-style": name, onclick: () => app.change({ style: name }) }, label));
  const close = app.store.watch(["settings"], () => buttons.forEach((/** @type {HTMLElement} */ button) => put(button, "aria-pressed", String(button.dataset.style === app.value("style")))));
  return { element: h("section", { "aria-labelledby": "styles-title" }, h("h2", { id: "styles-title" }, "Way of drawing"), h("div", { class: "chips" }, buttons)), close };
}

/** @param {App} app */
function foot(app) {
  const reset = h("button", { type: "button", onclick: () => app.setSettings({}) }, "As it was");
  const close = app.store.watch(["settings"], ({ settings }) => (reset.disabled = !Object.keys(settings).length));
  return { element: h("section", {}, h("div", { class: "row apart" }, reset, h("a", { class: "button primary", href: "#watch" }, "Watch it drawn"))), close };
}
