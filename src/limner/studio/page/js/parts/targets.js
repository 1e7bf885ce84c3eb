// What is connected goes in; a choice of machines, each with its state, comes out.

import { ask } from "../api.js";
import { h, put } from "../dom.js";

/** @typedef {import("../app.js").App} App */

const LOOK = new Map([["ready", "good"], ["not connected", "bad"]]);

/** @param {App} app @param {() => void} chosen */
export function targetsPart(app, chosen) {
  /** @type {any[]} */
  let targets = [];
  let to = "";
  const list = h("ul", { class: "picks" });
  const own = h("input", { type: "text", id: "address", placeholder: "grbl:/dev/ttyUSB0", autocomplete: "off", spellcheck: "false", "aria-describedby": "address-help", onchange: () => own.value.trim() && pick(own.value.trim()) });
  const help = h("p", { class: "small quiet", id: "address-help" });
  const again = h("button", { type: "button", class: "plain", onclick: () => look() }, "Look again");
  const element = h("section", { "aria-labelledby": "target-title" }, h("div", { class: "row apart" }, h("h2", { id: "target-title" }, "Machine"), again), list,
    h("div", { class: "field" }, h("label", { for: "address" }, "Or by its address"), own, help));
  const kind = () => (app.state.robot ? "arm" : "plotter");
  const pick = (/** @type {string} */ address) => ((to = address), render(), chosen());
  const render = () => {
    const fitting = targets.filter((target) => target.kind === kind());
    help.textContent = kind() === "arm" ? "ur:HOST for an arm of Universal Robots, rosbridge:HOST for ROS" : "grbl:PORT or ebb:PORT (an AxiDraw)";
    put(own, "placeholder", kind() === "arm" ? "ur:192.168.0.2" : "grbl:/dev/ttyUSB0");
    list.replaceChildren(...fitting.map((target) => h("li", {}, h("button", { type: "button", class: "pick", "aria-pressed": String(target.address === to), onclick: () => pick(target.address) },
      h("span", { class: `dot ${LOOK.get(target.state) ?? ""}` }),
      h("span", { class: "grow" }, h("b", {}, target.label), h("span", { class: "small quiet" }, [target.state, target.help].filter(Boolean).join(" · ")))))));
  };
  const look = async () => {
    try {
      ({ targets } = await ask("api/targets"));
    } catch {
      targets = [];
    }
    // An address of one's own is in no list.
    const kept = to && to === own.value.trim();
    if (!kept && !targets.some((target) => target.address === to)) to = targets.find((target) => target.kind === kind())?.address ?? "";
    render();
    chosen();
  };
  const stop = app.store.watch(["robot"], () => targets.length && ((own.value = ""), look()));
  look();
  return { element, get to() { return to; }, close: stop };
}
