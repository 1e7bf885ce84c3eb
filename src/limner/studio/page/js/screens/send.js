// The last screen: a machine is chosen and checked, the drawing sent, and its progress shown.

import { tell } from "../api.js";
import { h } from "../dom.js";
import { duration, sentence } from "../format.js";
import { decode } from "../frames.js";
import { pageOf, pointCount } from "../ink.js";
import { busy, there } from "../job.js";
import { drawerPart } from "../parts/arm.js";
import { jobPart } from "../parts/job.js";
import { targetsPart } from "../parts/targets.js";
import { Sheet } from "../sheet.js";

/** @typedef {import("../app.js").App} App */

/** @param {App} app */
export function sendScreen(app) {
  const sheet = new Sheet({ label: "The drawing on the machine" });
  sheet.hint = true;
  const panel = h("div", { class: "panel" });
  const job = jobPart(app);
  const start = preparing(app);
  const heading = h("h1", {}, "Send");
  const empty = h("section", {}, h("p", { class: "quiet" }, "Nothing to send yet."), h("a", { class: "button", href: "#photo" }, "Take a photo"));
  let lined = "";
  /** The strokes that the machine has, or those on the desk. */
  const follow = async (/** @type {any} */ state) => {
    const { job: now, preview } = state;
    if (there(now) && now.mine && now.drawing && now.drawing !== lined) {
      lined = now.drawing;
      const [lines, report] = await Promise.all([linesOf(now.drawing), reportOf(now.drawing)]).catch(() => []);
      // Another job may have begun meanwhile.
      if (lined !== now.drawing) return;
      if (!lines) lined = "";
      else sheet.show(lines, report ? pageOf(report) : app.state.preview?.page, 0);
    } else if (!there(now) && preview && preview.lines !== sheet.ink.lines) {
      lined = "";
      sheet.show(preview.lines, preview.page);
    }
    if (there(app.state.job) && lined && !app.state.job.frame_only) {
      const { offsets } = sheet.ink.lines;
      sheet.showUntil(offsets[Math.min(app.state.job.stroke, offsets.length - 1)] ?? 0);
    } else sheet.showUntil(pointCount(sheet.ink.lines));
  };
  let layout = "";
  const arrange = (/** @type {any} */ { job: now, preview }) => {
    const next = there(now) ? (busy(now) || !preview ? "job" : "both") : preview ? "start" : "empty";
    if (next === layout) return;
    layout = next;
    panel.replaceChildren(heading, .../** @type {any} */ ({ job: [job.element], both: [job.element, ...start.parts], start: start.parts, empty: [empty] })[next]);
  };
  const stop = app.store.watch(["job", "preview"], (state) => {
    if (state.job) job.show(state.job);
    arrange(state);
    start.refresh();
    follow(state);
  });
  const view = h("div", { class: "view" }, sheet.element);
  const element = h("div", { class: "split screen" }, h("div", { class: "stage" }, view), panel);
  return { element, close: () => (stop(), start.close(), sheet.close()) };
}

/** @param {string} drawing */
async function linesOf(drawing) {
  const answer = await fetch(`api/drawing/${drawing}.lines`);
  return answer.ok ? decode(await answer.arrayBuffer()).lines ?? null : null;
}

/** @param {string} drawing */
async function reportOf(drawing) {
  const { drawings } = await (await fetch("api/drawings")).json();
  return drawings.find((/** @type {any} */ kept) => kept.drawing === drawing)?.report;
}

/** Machine, checklist, dry run and start. @param {App} app */
function preparing(app) {
  const drawer = drawerPart(app);
  const list = h("div", { class: "stack tight" });
  const ready = h("p", { class: "quiet" });
  const frame = h("button", { type: "button", onclick: () => send(true) }, "Dry run round the frame");
  const go = h("button", { type: "button", class: "primary", disabled: true, onclick: () => send(false) }, "Start drawing");
  const trouble = h("p", { class: "note bad", role: "alert", hidden: true });
  let asked = 0;
  let asking = "";
  const body = async () => {
    const kept = await app.keep();
    return kept && { drawing: kept.drawing, to: targets.to, ...app.drawer };
  };
  const send = async (/** @type {boolean} */ frameOnly) => {
    const order = await body();
    const job = order && (await app.command("api/job", { ...order, frame_only: frameOnly }));
    if (job) app.set({ job });
  };
  /** The machine's own checklist; whatever is asked later takes its place. */
  const check = async () => {
    const mine = (asked += 1);
    go.disabled = true;
    if (!targets.to || !app.state.preview) return;
    try {
      const order = await body();
      const told = order && (await tell("api/job/check", order));
      if (mine !== asked || !told) return;
      trouble.hidden = true;
      ready.textContent = `${told.name}: ${told.strokes} strokes in ${duration(told.seconds)}. ${told.ready}`;
      show([told.ask].flat().filter(Boolean));
    } catch (error) {
      if (mine !== asked) return;
      trouble.hidden = false;
      trouble.textContent = sentence(error instanceof Error ? error.message : String(error));
      show([]);
    }
  };
  const show = (/** @type {string[]} */ points) => {
    if (points.join("\n") === asking) return refresh();
    asking = points.join("\n");
    const boxes = points.map((point) => {
      const box = h("input", { type: "checkbox", onchange: () => refresh() });
      return { box, label: h("label", { class: "check block" }, box, h("span", {}, point)) };
    });
    checks = boxes.map(({ box }) => box);
    list.replaceChildren(...boxes.map(({ label }) => label));
    return refresh();
  };
  /** @type {HTMLInputElement[]} */
  let checks = [];
  const refresh = () => {
    const may = app.state.job?.may.includes("start") ?? true;
    go.disabled = !may || !targets.to || !trouble.hidden || !checks.length || checks.some((box) => !box.checked);
    frame.disabled = !may || !targets.to || !trouble.hidden;
  };
  const targets = targetsPart(app, () => check());
  const stop = app.store.watch(["robot", "settings"], () => targets.to && check());
  const parts = [
    drawer.element, targets.element,
    h("section", { "aria-labelledby": "check-title" }, h("h2", { id: "check-title" }, "Before it starts"), ready, list, trouble, h("div", { class: "row" }, frame, go)),
  ];
  return { parts, refresh, close: () => (stop(), drawer.close(), targets.close()) };
}
