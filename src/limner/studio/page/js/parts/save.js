// The drawing goes in; a dialog that saves it as a file comes out.

import { h } from "../dom.js";

/** What each format is, and which of them need a plotter or an arm. */
const ABOUT = new Map([
  ["svg", ["SVG", "Inkscape, vpype"]], ["png", ["PNG", "a picture"]], ["gcode", ["G-code", "GRBL plotters"]], ["hpgl", ["HP-GL", "pen plotters"]],
  ["json", ["JSON", "the strokes"]], ["npz", ["NPZ", "for Python"]], ["toml", ["TOML", "the settings"]], ["gif", ["GIF", "a film of it"]], ["mp4", ["MP4", "a film of it"]],
  ["picture.png", ["Picture", "in colours, PNG"]], ["trajectory.json", ["Motion", "of the arm, JSON"]], ["trajectory.csv", ["Motion", "of the arm, CSV"]], ["trajectory.npz", ["Motion", "of the arm, NPZ"]],
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
  const { robot } = app.state;
  const query = robot ? `?robot=${robot}` : `?machine=${app.value("machine")}`;
  const fitting = [...app.options.exports.filter((/** @type {string} */ format) => robot || !format.startsWith("trajectory")), ...(app.pictured(app.value("style")) ? ["picture.png"] : [])];
  const links = fitting.map((/** @type {string} */ format) => {
    const [name, about] = ABOUT.get(format) ?? [format.toUpperCase(), ""];
    const link = h("button", { type: "button", class: "button", "data-format": format }, h("b", {}, name), h("small", {}, about));
    link.onclick = () => app.save(format, query).then((done) => done && dialog.close());
    return link;
  });
  return h("div", { class: "stack" }, h("h2", { id: "dialog-title" }, "Save the drawing"),
    h("p", { class: "quiet" }, robot ? "What you save stays with you. All else is gone when limner ends." : "What you save stays with you. All else is gone when limner ends. Choose an arm under Watch to save its motion."), h("div", { class: "saves" }, links),
    h("div", { class: "row" }, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
}
