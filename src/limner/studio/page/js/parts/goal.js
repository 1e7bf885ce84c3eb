// What draws in the booth is chosen here: a plotter or an arm by its name, and where it is.

import { ask } from "../api.js";
import { h, put } from "../dom.js";

const OTHER = "other";

/** @param {(goal: {to: string, machine: string | null, robot: string | null}) => void} use */
export function goalPart(use) {
  /** @type {any[]} */
  let targets = [];
  const drawer = h("select", { id: "drawer", onchange: () => places() });
  const place = h("select", { id: "place", onchange: () => other() });
  const address = h("input", { id: "to", type: "text", autocomplete: "off", spellcheck: "false", required: true });
  const field = h("div", { class: "field", hidden: true }, h("label", { for: "to" }, "Address"), address);
  const said = h("p", { class: "small quiet", role: "status" });
  const send = h("button", { type: "submit" }, "Use this machine");
  const again = h("button", { type: "button", class: "plain", onclick: () => load() }, "Look again");
  const form = h("form", { class: "stack tight", onsubmit: (/** @type {Event} */ event) => (event.preventDefault(), use(chosen())) },
    h("div", { class: "field" }, h("label", { for: "drawer" }, "Drawn by"), drawer), h("div", { class: "field" }, h("label", { for: "place" }, "Where"), place), said, field,
    h("div", { class: "row apart" }, send, again));
  const element = h("section", { class: "stack tight", "aria-labelledby": "machine-title" }, h("h2", { id: "machine-title" }, "Machine"), form);

  const robot = () => drawer.value.startsWith("robot:");
  const chosen = () => {
    const [kind, name] = drawer.value.split(":");
    const to = place.value === OTHER ? address.value.trim() : place.value;
    return { to, machine: kind === "machine" ? name : null, robot: kind === "robot" ? name : null };
  };
  /** Where such a machine may be; an address of one's own comes last. @param {string} [to] */
  const places = (to = place.value) => {
    const fitting = targets.filter(({ kind, address: at }) => at && kind === (robot() ? "arm" : "plotter"));
    place.replaceChildren(...fitting.map((target) => h("option", { value: target.address }, target.label)), h("option", { value: OTHER }, "Another address…"));
    const known = fitting.some((target) => target.address === to);
    place.value = known ? to : to && to !== OTHER && !targets.some((target) => target.address === to) ? OTHER : fitting[0]?.address ?? OTHER;
    if (place.value === OTHER && to !== OTHER) address.value = to;
    other();
  };
  const other = () => {
    const own = place.value === OTHER;
    field.hidden = !own;
    address.disabled = !own;
    put(address, "placeholder", robot() ? "ur:192.168.0.2" : "ebb:/dev/ttyACM0");
    const target = targets.find(({ kind, address: at }) => at === place.value && kind === (robot() ? "arm" : "plotter"));
    said.textContent = own ? (robot() ? "ur:HOST for an arm of Universal Robots, rosbridge:HOST for ROS" : "grbl:PORT or ebb:PORT (an AxiDraw)") : [target?.state, target?.help].filter(Boolean).join(" · ");
  };
  const load = async () => {
    ({ targets } = await ask("api/operator/targets").catch(() => ({ targets: [] })));
    places();
  };
  /** As the server has it. @param {{to: string, machine: string | null, robot: string | null}} goal */
  const show = async (goal) => {
    const { machines, robots } = await ask("api/operator/options");
    const option = (/** @type {string} */ kind) => (/** @type {any} */ { name }) => h("option", { value: `${kind}:${name}` }, name);
    drawer.replaceChildren(h("option", { value: "" }, "The plotter of each drawing"),
      h("optgroup", { label: "Plotters" }, machines.map(option("machine"))), h("optgroup", { label: "Arms" }, robots.map(option("robot"))));
    drawer.value = goal.robot ? `robot:${goal.robot}` : goal.machine ? `machine:${goal.machine}` : "";
    ({ targets } = await ask("api/operator/targets"));
    places(goal.to);
  };
  return { element, show };
}
