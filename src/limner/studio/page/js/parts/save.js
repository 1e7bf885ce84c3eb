// The drawing goes in; a dialog that saves it as a file comes out.

import { h } from "../dom.js";

const ABOUT = new Map([
  ["svg", "for Inkscape, vpype"], ["png", "a picture"], ["gcode", "GRBL plotters"], ["hpgl", "pen plotters"], ["json", "strokes as numbers"], ["npz", "for Python"],
  ["toml", "the settings"], ["gif", "a film"], ["mp4", "a film"], ["trajectory", "an arm's motion"], ["pdf", "to print"],
]);

/** @param {import("../app.js").App} app */
export function saveDialog(app) {
  const dialog = /** @type {HTMLDialogElement} */ (document.getElementById("dialog"));
  const button = /** @type {HTMLButtonElement} */ (document.getElementById("save"));
  button.addEventListener("click", () => {
    dialog.replaceChildren(content(app, dialog));
    dialog.showModal();
  });
}

/** @param {import("../app.js").App} app @param {HTMLDialogElement} dialog */
function content(app, dialog) {
  const links = app.options.exports.map((/** @type {string} */ format) => {
    const link = h("button", { type: "button", class: "button", "data-format": format }, h("b", {}, format.toUpperCase()), h("small", {}, ABOUT.get(format) ?? ""));
    link.onclick = () => app.save(format).then((done) => done && dialog.close());
    return link;
  });
  return h("div", { class: "stack" }, h("h2", { id: "dialog-title" }, "Save the drawing"),
    h("p", { class: "quiet" }, "What you save stays with you. All else is gone when limner ends."), h("div", { class: "saves" }, links),
    h("div", { class: "row" }, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
}
