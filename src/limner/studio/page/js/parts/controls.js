// A player goes in; its buttons, scrubber, speeds and what is shown of the pen's way come out.

import { h, icon, ICONS, put } from "../dom.js";
import { clock, duration } from "../format.js";

/** @typedef {import("../player.js").Player} Player */

const SPEEDS = [1, 4, 16, 64];
const USUAL_SPEED = 16;

export function playerControls() {
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
  const playing = (/** @type {boolean} */ on) => {
    play.replaceChildren(icon(on ? ICONS.pause : ICONS.play));
    play.setAttribute("aria-label", on ? "Pause" : "Play");
  };
  const show = (/** @type {number} */ time, /** @type {number} */ total) => {
    scrub.value = String(total ? time / total : 0);
    put(scrub, "aria-valuetext", `${duration(time)} of ${duration(total)}`);
    const text = `${clock(time)} / ${clock(total)}`;
    if (said.textContent !== text) said.textContent = text;
  };
  return { element, travel, order, bind, playing, show };
}
