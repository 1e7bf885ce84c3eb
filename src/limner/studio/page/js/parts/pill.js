// The job on the machine goes in; a small sign of it in the bar, on every screen, comes out.

import { h } from "../dom.js";
import { percent } from "../format.js";
import { busy, stateWords } from "../job.js";

/** @param {import("../app.js").App} app */
export function jobPill(app) {
  const pill = /** @type {HTMLAnchorElement} */ (document.getElementById("job-pill"));
  app.store.watch(["job", "online"], ({ job, online }) => {
    pill.hidden = online && !busy(job);
    if (!online) pill.replaceChildren(h("span", { class: "dot bad" }), "not connected");
    else if (job) pill.replaceChildren(h("span", { class: "dot good" }), `${stateWords(job)} ${percent(job.share)}`);
  });
}
