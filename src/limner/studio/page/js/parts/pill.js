// The job on the machine goes in; a small sign of it in the bar, on every screen, comes out.

import { h } from "../dom.js";
import { percent } from "../format.js";
import { broken, busy, stateWords } from "../job.js";

/** @param {import("../app.js").App} app */
export function jobPill(app) {
  const pill = /** @type {HTMLAnchorElement} */ (document.getElementById("job-pill"));
  app.store.watch(["job", "online"], ({ job, online }) => {
    const stuck = Boolean(job && broken(job));
    pill.hidden = online && !busy(job) && !stuck;
    if (!online) pill.replaceChildren(h("span", { class: "dot bad" }), "not connected");
    else if (job) pill.replaceChildren(h("span", { class: `dot ${stuck ? "bad" : "good"}` }), `${stateWords(job)} ${percent(job.share)}`);
  });
}
