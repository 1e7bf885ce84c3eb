// The job on the machine goes in; its progress, and the buttons for what may be done now, come out.

import { h } from "../dom.js";
import { clock, duration, percent } from "../format.js";
import { helpWords, stateWords } from "../job.js";

/** @typedef {import("../app.js").App} App */

const BUTTONS = [
  ["pause", "Pause at the next lift", ""], ["resume", "Go on", "primary"], ["cancel", "Stop, pen up", ""], ["clear", "Put away", ""],
];

/** @param {App} app @param {string} [base] where commands go */
export function jobPart(app, base = "api/job") {
  const big = h("p", { class: "big" });
  const title = h("h2", { id: "job-title" });
  const bar = h("progress", { max: 1, "aria-labelledby": "job-title" });
  const said = h("p", { class: "quiet number" });
  const help = h("p", { role: "status" });
  const buttons = BUTTONS.map(([action, name, kind]) =>
    h("button", { type: "button", class: kind, "data-action": action, onclick: () => app.command(`${base}/${action}`, {}).then((job) => job?.state && app.set({ job })) }, name));
  const element = h("section", { class: "job", "aria-labelledby": "job-title" }, title, big, bar, said, help, h("div", { class: "row" }, buttons));
  const show = (/** @type {import("../job.js").Job} */ job) => {
    title.textContent = stateWords(job);
    for (const part of [big, bar, said]) part.hidden = job.state === "idle";
    big.textContent = percent(job.share);
    bar.value = job.share;
    said.textContent = job.frame_only ? job.name : `Stroke ${job.stroke} of ${job.strokes} · ${clock(job.elapsed_s)} gone${job.state === "done" ? "" : `, ${duration(job.left_s)} left`} · ${job.name}`;
    const words = helpWords(job);
    if (help.textContent !== words) help.textContent = words;
    help.className = job.error ? "note bad" : "";
    buttons.forEach((button) => button.dataset.action === "resume" && (button.textContent = job.next_pen ? "The next pen is in" : "Go on"));
    buttons.forEach((button) => (button.hidden = !job.may.includes(button.dataset.action ?? "")));
  };
  return { element, show };
}
