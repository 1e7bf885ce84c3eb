// A line of text goes in; it is shown for a while at the foot of the page, and read out.

import { h } from "./dom.js";

const SHOWN_MS = 7000;

/**
 * @param {string} text
 * @param {{action?: string, act?: () => void}} [offer] a button beside it
 */
export function toast(text, { action, act } = {}) {
  const place = /** @type {HTMLElement} */ (document.getElementById("toasts"));
  const line = h("div", { class: "toast" }, h("span", {}, text));
  const away = () => line.remove();
  line.append(h("button", { type: "button", class: "plain", onclick: () => (away(), act?.()) }, action ?? "Close"));
  place.replaceChildren(line);
  setTimeout(away, SHOWN_MS);
}
