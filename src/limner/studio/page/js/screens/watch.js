// The fifth screen: the drawing drawn, in the machine's own time or faster, on its page and by the arm.

import { context, themeColour } from "../canvas.js";
import { h, icon, ICONS, put } from "../dom.js";
import { clock, duration } from "../format.js";
import { pointCount } from "../ink.js";
import { armPart } from "../parts/arm.js";
import { figures } from "../parts/figures.js";
import { Player } from "../player.js";
import { Sheet } from "../sheet.js";
import { estimate } from "../timeline.js";
import { calm } from "../motion.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../timeline.js").Timeline} Timeline */

const SPEEDS = [1, 4, 16, 64];
const USUAL_SPEED = 16;
const EVEN = { draw: 60, travel: 150, lift: 0.15 };

/** @param {App} app */
export function watchScreen(app) {
  const sheet = new Sheet({ label: "The drawing being drawn" });
  const arm = armPart(app);
  const controls = playerControls();
  /** @type {Timeline | null} */
  let timeline = null;
  let ratio = 1;
  const show = (/** @type {number} */ time) => {
    if (!timeline) return;
    const pen = timeline.at(time / ratio);
    sheet.showUntil(pen.ink);
    penMark(sheet, pen, timeline);
    arm.show(time, pen);
    controls.show(time, player.duration);
  };
  const player = new Player(show, (playing) => controls.playing(playing));
  controls.bind(player);
  /** @type {any} */ (globalThis).limnerPlayer = player;

  const look = () => {
    sheet.setLook({ travel: controls.travel.checked, byOrder: controls.order.checked, red: arm.unreachable });
    show(player.time);
  };
  controls.travel.onchange = controls.order.onchange = look;
  sheet.element.addEventListener("rendered", () => timeline && penMark(sheet, timeline.at(player.time / ratio), timeline));
  const facts = h("section", {});
  const stop = app.store.watch(["preview"], ({ preview }) => {
    if (!preview || preview.lines === sheet.ink.lines) return;
    const old = player.duration;
    timeline = estimate(preview.lines, EVEN);
    // The shares of the estimate, in the time that the machine's own planner found.
    ratio = preview.report.seconds / Math.max(timeline.duration, 1e-6);
    player.duration = preview.report.seconds;
    sheet.show(preview.lines, preview.page, old ? sheet.until : pointCount(preview.lines));
    player.seek(old ? (player.time / old) * player.duration : player.duration);
    facts.replaceChildren(h("h2", {}, "What it takes"), figures(preview.report));
    if (!old && !calm()) { player.seek(0); player.play(); }
  });
  arm.onchange = look;
  const view = h("div", { class: "view" }, sheet.element, arm.view);
  const panel = h("div", { class: "panel" }, h("h1", {}, "Watch"), facts, arm.element,
    h("section", {}, h("a", { class: "button primary", href: "#send" }, "Send it to the machine")));
  const element = h("div", { class: "split screen watch" }, h("div", { class: "stage" }, view, controls.element), panel);
  return { element, close: () => (stop(), player.pause(), arm.close(), sheet.close()) };
}

/** The pen, and its way through the air, over the ink. @param {Sheet} sheet @param {import("../timeline.js").PenState} pen @param {Timeline} timeline */
function penMark(sheet, pen, timeline) {
  if (!sheet.over || !sheet.element.clientWidth) return;
  const layer = sheet.over;
  const paint = context(layer);
  paint.clearRect(0, 0, layer.width, layer.height);
  const ratio = layer.width / sheet.element.clientWidth;
  const [x, y] = sheet.pixel(pen.x, pen.y);
  const { points, unit } = timeline;
  paint.beginPath();
  paint.moveTo(...spot(sheet, points[2 * pen.sample] * unit, points[2 * pen.sample + 1] * unit));
  paint.lineTo(x, y);
  paint.lineWidth = pen.down ? sheet.ink.widthPx : ratio;
  paint.lineCap = "round";
  paint.strokeStyle = pen.down ? themeColour("--sheet-ink") : "rgb(184 54 28 / 60%)";
  paint.stroke();
  paint.beginPath();
  paint.arc(x, y, (pen.down ? 4 : 6) * ratio, 0, 7);
  paint.fillStyle = "#b8361c";
  paint.globalAlpha = pen.down ? 1 : 0.45;
  paint.fill();
  paint.globalAlpha = 1;
}

/** @param {Sheet} sheet @param {number} x @param {number} y @returns {[number, number]} */
function spot(sheet, x, y) {
  const [px, py] = sheet.pixel(x, y);
  return [px, py];
}

/** Play, scrubber, speeds, what is shown. */
function playerControls() {
  const play = h("button", { type: "button", class: "icon primary", "aria-label": "Play" }, icon(ICONS.play));
  const scrub = h("input", { type: "range", min: 0, max: 1, step: "any", "aria-label": "Time" });
  const said = h("span", { class: "clock" });
  const travel = h("input", { type: "checkbox" });
  const order = h("input", { type: "checkbox" });
  const speeds = SPEEDS.map((speed) => h("button", { type: "button", "aria-pressed": String(speed === USUAL_SPEED) }, `${speed}×`));
  const element = h("div", { class: "under" }, h("div", { class: "player" }, play, scrub, said,
    h("div", { class: "tools" }, h("div", { class: "segmented", role: "group", "aria-label": "Speed" }, speeds),
      h("label", { class: "check" }, travel, "Moves of the lifted pen"), h("label", { class: "check" }, order, "Colour by order"))));
  const bind = (/** @type {Player} */ player) => {
    player.speed = USUAL_SPEED;
    play.onclick = () => (player.playing ? player.pause() : player.play());
    scrub.oninput = () => (player.pause(), player.seek(Number(scrub.value) * player.duration));
    speeds.forEach((button, i) => {
      button.onclick = () => {
        player.speed = SPEEDS[i];
        speeds.forEach((other, k) => put(other, "aria-pressed", String(k === i)));
      };
    });
  };
  return {
    element, travel, order, bind,
    playing: (/** @type {boolean} */ on) => {
      play.replaceChildren(icon(on ? ICONS.pause : ICONS.play));
      play.setAttribute("aria-label", on ? "Pause" : "Play");
    },
    show: (/** @type {number} */ time, /** @type {number} */ total) => {
      scrub.value = String(total ? time / total : 0);
      put(scrub, "aria-valuetext", `${duration(time)} of ${duration(total)}`);
      said.textContent = `${clock(time)} / ${clock(total)}`;
    },
  };
}
