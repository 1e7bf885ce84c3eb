// Candidates come in one by one; they lie side by side, each with what it costs, and one click chooses.

import { h, put } from "../dom.js";
import { count, duration, length, percent } from "../format.js";
import { Sheet } from "../sheet.js";
import { notes } from "../parts/notes.js";

/** @typedef {import("../app.js").App} App */

/** @param {App} app */
export function chooseScreen(app) {
  const cards = h("ul", { class: "cards" });
  const status = h("p", { class: "quiet", role: "status" });
  const next = h("a", { class: "button primary", href: "#adjust" }, "Go on with this one");
  const element = h("div", { class: "choose screen" },
    h("header", {}, h("div", { class: "stack tight" }, h("h1", {}, "Which one is it?"), status), next),
    notes(app), cards);
  /** @type {Map<number, {view: any, close: () => void, key: any}>} */
  const shown = new Map();

  const refresh = () => {
    const { candidates, drawing, drawingError } = app.state;
    const ready = candidates.filter(Boolean).length;
    const all = candidates.length && ready === candidates.length;
    status.textContent = drawingError || (all ? "Every way of drawing has its own character. Choose one; all can be adjusted." : "Drawing the candidates…");
    for (let i = 0; i < Math.max(candidates.length, shown.size, drawing ? 4 : 0); i += 1) {
      const candidate = candidates[i];
      const old = shown.get(i);
      if (old && (old.key === candidate || (!candidate && !all))) continue;
      old?.close();
      const card = candidate ? cardOf(app, candidate) : waiting();
      shown.set(i, { ...card, key: candidate });
      if (old) old.view.replaceWith(card.view);
      else cards.append(card.view);
    }
    mark();
  };
  const mark = () => {
    for (const { view, key } of shown.values()) if (key) choose(view, chosen(app, key));
  };
  const stop = app.store.watch(["candidates", "drawing", "drawingError", "settings"], refresh);
  return { element, close: () => (stop(), shown.forEach((card) => card.close())) };
}

/** Whether a candidate is what is drawn now. @param {App} app @param {any} candidate */
function chosen(app, { settings }) {
  return Object.entries(settings).every(([path, value]) => app.value(path) === value);
}

/** @param {HTMLElement} view @param {boolean} is */
function choose(view, is) {
  const button = view.querySelector("button");
  if (!button) return;
  put(button, "aria-pressed", String(is));
  /** @type {HTMLElement} */ (button.querySelector(".tick")).textContent = is ? "chosen" : "";
}

function waiting() {
  return { view: h("li", {}, h("div", { class: "card" }, h("div", { class: "paper waiting" }, h("span", { class: "spinner" })))), close: () => {} };
}

/** @param {App} app @param {any} candidate */
function cardOf(app, candidate) {
  if (!candidate.lines) {
    return { view: h("li", {}, h("div", { class: "card" }, h("div", { class: "paper waiting small quiet" }, candidate.error ?? "nothing to draw"), h("span", { class: "name" }, candidate.label))), close: () => {} };
  }
  const sheet = new Sheet({ bare: true, label: "" });
  sheet.element.setAttribute("aria-hidden", "true");
  sheet.element.removeAttribute("role");
  sheet.element.removeAttribute("aria-label");
  sheet.show(candidate.lines, candidate.page);
  const paper = h("span", { class: "paper" }, sheet.element);
  paper.style.aspectRatio = `${candidate.page.width_mm} / ${candidate.page.height_mm}`;
  const take = () => app.choose(candidate);
  const button = h("button", { type: "button", class: "card", onclick: take, ondblclick: () => app.go("adjust") },
    paper, h("span", { class: "name" }, candidate.label, h("span", { class: "tick" })), facts(candidate.report),
    app.pictured(candidate.settings.style) && h("span", { class: "small quiet" }, "With a picture in colours"));
  return { view: h("li", {}, button), close: () => sheet.close() };
}

/** @param {any} report */
function facts(report) {
  const rows = [["Time", duration(report.seconds)], ["Strokes", count(report.strokes)], ["Ink", length(report.ink_mm)], ["Likeness", percent(report.likeness)]];
  const meter = h("i");
  meter.style.width = percent(report.likeness).replace(" ", "");
  return [
    h("span", { class: "facts" }, rows.map(([name, value]) => [h("span", {}, name), h("span", { class: "end" }, value)])),
    h("span", { class: "meter", "aria-hidden": "true" }, meter),
  ];
}
