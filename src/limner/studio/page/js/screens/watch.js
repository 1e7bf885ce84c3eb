// The fifth screen: the drawing drawn, in the machine's own time or faster, on its page and by the arm.

import { h } from "../dom.js";
import { pointCount } from "../ink.js";
import { calm } from "../motion.js";
import { armView, drawerPart } from "../parts/arm.js";
import { figures } from "../parts/figures.js";
import { playerControls } from "../parts/controls.js";
import { PenMark } from "../penmark.js";
import { Player } from "../player.js";
import { Sheet } from "../sheet.js";
import { estimate, fromPlan } from "../timeline.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../timeline.js").Timeline} Timeline */
/** @typedef {{timeline: Timeline, ink: (sample: number) => number, stretch: number}} Film stretch: seconds of the film per second of the timeline */

const EVEN = { draw: 60, travel: 150, lift: 0.15 };

/** @param {App} app */
export function watchScreen(app) {
  const sheet = new Sheet({ label: "The drawing being drawn" });
  const mark = new PenMark(sheet);
  const arm = armView(app);
  const drawer = drawerPart(app);
  const controls = playerControls();
  /** @type {Film | null} */
  let film = null;
  let shown = /** @type {any} */ (null);
  const show = (/** @type {number} */ time) => {
    if (!film) return;
    const pen = film.timeline.at(time / film.stretch);
    sheet.showUntil(film.ink(pen.sample));
    mark.show(film.timeline, pen);
    arm.show(pen, film.ink(pen.sample));
    controls.show(time, player.duration);
  };
  const player = new Player(show, (playing) => controls.playing(playing));
  controls.bind(player);
  Object.assign(globalThis, { limnerPlayer: player });

  const look = () => {
    const red = new Set(app.state.plan?.unreachable ?? []);
    sheet.setLook({ travel: controls.travel.checked, byOrder: controls.order.checked, red });
    show(player.time);
  };
  const load = (/** @type {any} */ lines, /** @type {any} */ page, /** @type {Film} */ next, /** @type {number} */ seconds) => {
    // What cannot be drawn is seen at once, not when its turn comes.
    const stuck = Boolean(app.state.plan?.unreachable?.length);
    const share = stuck ? 1 : player.duration ? player.time / player.duration : calm() ? 1 : 0;
    const first = !player.duration;
    if (stuck) player.pause();
    film = next;
    player.duration = seconds;
    sheet.show(lines, page, 0);
    player.time = share * seconds;
    look();
    if (first && !stuck && !calm()) player.play();
  };
  controls.travel.onchange = controls.order.onchange = look;
  sheet.element.addEventListener("rendered", () => film && mark.show(film.timeline, film.timeline.at(player.time / film.stretch)));
  const facts = h("section", { "aria-labelledby": "takes" });
  const stop = app.store.watch(["preview", "plan"], ({ preview, plan }) => {
    if (!preview || shown === (plan ?? preview)) return;
    shown = plan ?? preview;
    facts.replaceChildren(h("h2", { id: "takes" }, "What it takes"), figures({ ...preview.report, seconds: plan?.seconds ?? preview.report.seconds }));
    if (plan?.times?.length) {
      const { timeline, lines, inkAt } = fromPlan(plan);
      load(lines, preview.page, { timeline, ink: (sample) => inkAt[sample], stretch: 1 }, timeline.duration);
      arm.plan(plan, lines);
    } else {
      const timeline = estimate(preview.lines, EVEN);
      // The shares of the estimate, in the time that the machine's own planner found.
      load(preview.lines, preview.page, { timeline, ink: (sample) => Math.min(sample + 1, pointCount(preview.lines)), stretch: preview.report.seconds / Math.max(timeline.duration, 1e-6) }, preview.report.seconds);
      arm.plan(plan, preview.lines);
    }
  });
  const view = h("div", { class: "view" }, sheet.element, arm.element);
  const panel = h("div", { class: "panel" }, h("h1", {}, "Watch"), facts, drawer.element, arm.panel,
    h("section", {}, h("a", { class: "button primary", href: "#send" }, "Send it to the machine")));
  const element = h("div", { class: "split screen watch" }, h("div", { class: "stage" }, view, controls.element), panel);
  return { element, close: () => (stop(), player.pause(), arm.close(), drawer.close(), sheet.close()) };
}
