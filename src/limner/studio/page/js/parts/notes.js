// What is wrong with a photo, and what would help, comes out as a note that can be put away.

import { h } from "../dom.js";

/** @param {import("../app.js").App} app */
export function notes(app) {
  const { photo } = app.state;
  if (!photo?.notes.length || photo.noted) return null;
  const note = h("div", { class: "note" }, h("strong", {}, "The photo could be better"), photo.notes.map((/** @type {string} */ line) => h("p", {}, line)));
  const away = () => (note.remove(), (photo.noted = true));
  note.append(h("div", { class: "row" },
    h("a", { class: "button", href: "#photo" }, "Take another"), h("button", { type: "button", onclick: away }, "Draw it all the same")));
  return note;
}
