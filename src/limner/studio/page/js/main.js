// The page goes in; the studio in it, one screen at a time, comes out.

import { connect } from "./app.js";
import { h, put } from "./dom.js";
import { takeDrops } from "./drops.js";
import { there } from "./job.js";
import { awayBanner } from "./parts/banner.js";
import { saveDialog } from "./parts/save.js";
import { remember, restore } from "./parts/desk.js";
import { jobPill } from "./parts/pill.js";
import { adjustScreen } from "./screens/adjust.js";
import { chooseScreen } from "./screens/choose.js";
import { faceScreen } from "./screens/face.js";
import { photoScreen } from "./screens/photo.js";
import { sendScreen } from "./screens/send.js";
import { watchScreen } from "./screens/watch.js";
import { themeButton } from "./theme.js";

const SCREENS = {
  photo: { name: "Photo", show: photoScreen },
  face: { name: "Face", show: faceScreen },
  choose: { name: "Choose", show: chooseScreen },
  adjust: { name: "Adjust", show: adjustScreen },
  watch: { name: "Watch", show: watchScreen },
  send: { name: "Send", show: sendScreen },
};
/** @typedef {keyof typeof SCREENS} Screen */

const main = /** @type {HTMLElement} */ (document.getElementById("main"));

/** @param {import("./app.js").App} app @returns {boolean} whether there is something to work on */
function begun({ state }) {
  return Boolean(state.photo && (state.photo.faces.length || state.points || state.placing));
}

/** @param {import("./app.js").App} app @param {string} name @returns {Screen} */
function allowed(app, name) {
  if (name === "send" && there(app.state.job)) return "send";
  return name in SCREENS && begun(app) ? /** @type {Screen} */ (name) : "photo";
}

/** @param {import("./app.js").App} app */
function steps(app) {
  const list = /** @type {HTMLElement} */ (document.getElementById("steps"));
  const links = Object.entries(SCREENS).map(([screen, { name }]) => h("a", { href: `#${screen}` }, name));
  list.replaceChildren(...links.map((link) => h("li", {}, link)));
  app.store.watch(["screen", "photo", "points", "placing", "preview", "job"], ({ screen, preview }) => {
    for (const link of links) {
      const target = link.hash.slice(1);
      put(link, "aria-current", target === screen && "step");
      put(link, "aria-disabled", allowed(app, target) !== target && "true");
    }
    /** @type {HTMLElement} */ (document.getElementById("save")).hidden = !preview;
  });
}

/** @param {import("./app.js").App} app */
function router(app) {
  /** @type {{element: HTMLElement, close: () => void} | null} */
  let view = null;
  let shown = "";
  const route = () => {
    const screen = allowed(app, location.hash.slice(1) || "photo");
    if (screen === shown) return;
    view?.close();
    app.entered(screen);
    view = SCREENS[screen].show(app);
    main.replaceChildren(view.element);
    main.scrollTop = 0;
    if (shown) main.focus({ preventScroll: true });
    shown = screen;
    document.title = `${SCREENS[screen].name} · limner studio`;
  };
  addEventListener("hashchange", route);
  route();
  // After a reload what was asked for may only now be there.
  app.store.watch(["job", "photo"], () => shown !== location.hash.slice(1) && route());
}

async function start() {
  themeButton(/** @type {HTMLButtonElement} */ (document.getElementById("theme")));
  const app = await connect();
  steps(app);
  takeDrops(app);
  jobPill(app);
  awayBanner(app);
  saveDialog(app);
  await restore(app);
  remember(app);
  app.recollect();
  router(app);
  // For whoever looks from the browser's console, and for the tests.
  Object.assign(globalThis, { limnerApp: app });
}

start().catch((error) => {
  main.replaceChildren(h("div", { class: "welcome" }, h("div", { class: "note bad", role: "alert" }, h("p", {}, error.message))));
});
