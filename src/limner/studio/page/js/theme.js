// A button goes in; it switches between the system's colours, light and dark, and remembers.

import { h, icon, ICONS } from "./dom.js";

const NEXT = { auto: "light", light: "dark", dark: "auto" };
const LOOK = { auto: ICONS.auto, light: ICONS.sun, dark: ICONS.moon };
const KEY = "limner-theme";

/** @typedef {"auto" | "light" | "dark"} Theme */

/** @param {HTMLButtonElement} button */
export function themeButton(button) {
  apply(button, remembered());
  button.addEventListener("click", () => apply(button, NEXT[remembered()]));
}

/** @returns {Theme} */
function remembered() {
  const theme = localStorage.getItem(KEY);
  return theme === "light" || theme === "dark" ? theme : "auto";
}

/** @param {HTMLButtonElement} button @param {any} theme */
function apply(button, theme) {
  localStorage.setItem(KEY, theme);
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  const name = `Colours: ${theme === "auto" ? "as the system" : theme}`;
  button.replaceChildren(icon(LOOK[/** @type {Theme} */ (theme)]), h("span", { class: "out-of-sight" }, name));
  button.title = name;
  dispatchEvent(new Event("limner-theme"));
}
