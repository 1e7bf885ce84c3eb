// The last screen: a machine is chosen and checked, the drawing sent, and its progress shown.

import { h } from "../dom.js";

/** @param {import("../app.js").App} app */
export function sendScreen(app) {
  void app;
  return { element: h("div", { class: "split screen" }), close: () => {} };
}
