// The arm that is to draw: chosen here, shown from above or in 3-D; what it cannot reach is red.

import { h } from "../dom.js";

/** @param {import("../app.js").App} app */
export function armPart(app) {
  const view = h("div", { hidden: true });
  const element = h("section", { hidden: true });
  void app;
  return {
    element, view,
    /** @type {Set<number> | undefined} */
    unreachable: undefined,
    onchange: () => {},
    show: (/** @type {number} */ _time, /** @type {any} */ _pen) => {},
    close: () => {},
  };
}
