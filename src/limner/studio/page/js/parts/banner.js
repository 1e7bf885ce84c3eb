// Whether the server answers goes in; while it does not, a line under the bar says so, and what to do.

const PATIENCE_MS = 1500;
const AWAY = "limner does not answer. Is it still running in its terminal? What is set here stays, and goes on when it is back.";
const STRANGER = "limner was started again. Open the address that it printed in its terminal; then this page goes on too.";

/** @param {import("../app.js").App} app */
export function awayBanner(app) {
  const banner = /** @type {HTMLElement} */ (document.getElementById("banner"));
  let timer = 0;
  app.store.watch(["online", "stranger"], ({ online, stranger }) => {
    clearTimeout(timer);
    if (online) banner.hidden = true;
    // A connection that is back at once is nobody's business.
    else timer = setTimeout(() => ((banner.textContent = stranger ? STRANGER : AWAY), (banner.hidden = false)), PATIENCE_MS);
  });
}
