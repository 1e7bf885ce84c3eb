// Who is to draw is chosen here; an arm is shown drawing, from above or in 3-D, and what it cannot reach is said.

import { ask } from "../api.js";
import { AboveView } from "../above.js";
import { h, put } from "../dom.js";
import { percent, sentence } from "../format.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../ink.js").Lines} Lines */

/** Plotter or arm. @param {App} app */
export function drawerPart(app) {
  const { machines, robots } = app.options;
  const option = (/** @type {string} */ kind) => (/** @type {any} */ { name }) => h("option", { value: `${kind}:${name}` }, name);
  const select = h("select", { id: "drawer", onchange: () => take(select.value) },
    h("optgroup", { label: "Plotters" }, machines.map(option("machine"))), h("optgroup", { label: "Arms" }, robots.map(option("robot"))));
  const take = (/** @type {string} */ value) => {
    const [kind, name] = value.split(":");
    if (kind === "machine") app.change({ machine: name });
    app.setRobot(kind === "robot" ? name : "");
  };
  const said = h("div", { role: "status", class: "stack tight small" });
  const stop = app.store.watch(["robot", "settings", "plan", "planError"], ({ robot, plan, planError }) => {
    select.value = robot ? `robot:${robot}` : `machine:${app.value("machine")}`;
    said.replaceChildren(...words(plan, planError, robot));
  });
  const element = h("section", { "aria-labelledby": "drawn-by" }, h("div", { class: "row apart" }, h("h2", { id: "drawn-by" }, h("label", { for: "drawer" }, "Drawn by")), select), said);
  return { element, close: stop };
}

/** @param {any} plan @param {string} error @param {string} robot */
function words(plan, error, robot) {
  if (error) return [h("div", { class: "note bad" }, h("p", {}, sentence(error)), plan?.unreachable?.length ? h("p", {}, "What is red cannot be reached.") : null)];
  if (!plan) return [h("p", { class: "row quiet" }, h("span", { class: "spinner" }), "Planning the motion…")];
  if (!robot) return [];
  return [h("p", { class: "quiet" }, `Joints stay ${plan.margin_deg?.toFixed(0)}° within their limits; ${percent(plan.velocity_used)} of their speed and ${percent(plan.acceleration_used)} of their acceleration are used.`)];
}

/** The joints between two samples of a plan. @param {any} plan @param {{sample: number, share: number}} pen @returns {number[]} */
function between(plan, { sample, share }) {
  const next = Math.min(sample + 1, plan.times.length - 1);
  const at = (/** @type {number} */ row, /** @type {number} */ k) => plan.joints[row * plan.dof + k];
  return Array.from({ length: plan.dof }, (_, k) => at(sample, k) + share * (at(next, k) - at(sample, k)));
}

function hasWebGl() {
  return Boolean(document.createElement("canvas").getContext("webgl2"));
}

/** The arm over the stage. @param {App} app */
export function armView(app) {
  const above = new AboveView();
  const room = h("div", { class: "arm3d", hidden: true });
  const element = h("div", { class: "sheet armview", hidden: true }, above.element, room);
  const views = [["sheet", "Sheet"], ["above", "From above"], ["space", "3-D"]].map(([key, name]) => h("button", { type: "button", "data-view": key, onclick: () => look(key) }, name));
  const said = h("p", { class: "small quiet", role: "status" });
  const panel = h("section", { hidden: true, "aria-labelledby": "view-title" }, h("h2", { id: "view-title" }, "View"), h("div", { class: "segmented", role: "group", "aria-label": "View" }, views), said);
  let view = "sheet";
  /** @type {any} */
  let space = null;
  /** @type {any} */
  let plan = null;
  /** @type {Lines | null} */
  let lines = null;
  /** @type {any} */
  let robot = null;
  let last = /** @type {any[] | null} */ (null);
  /** @type {any} the robot that the 3-D view is being made for */
  let entering = null;

  const look = (/** @type {string} */ key) => {
    view = key;
    views.forEach((button) => put(button, "aria-pressed", String(button.dataset.view === key)));
    element.hidden = key === "sheet" || !robot || !plan;
    above.element.hidden = key !== "above";
    room.hidden = key !== "space";
    said.textContent = "";
    if (key === "space") enterSpace();
    if (last) show(...last);
  };
  const enterSpace = async () => {
    if (space || !robot || entering === robot) return;
    if (!hasWebGl()) return flat("This browser shows no 3-D: WebGL is switched off, or this computer has none. Here is the arm from above.");
    said.textContent = "Loading the 3-D view…";
    const wanted = (entering = robot);
    try {
      const { Space } = await import("../../built/arm3d.js");
      const urdf = await (await fetch(`api/robot/${wanted.name}.urdf`)).text();
      // Another arm was chosen meanwhile, or the screen left.
      if (wanted !== entering) return;
      space = new Space(room, urdf);
      said.textContent = "Drag to turn, scroll to come nearer.";
      if (plan) space.setPlan({ ...plan, base: robot.base }, lines, app.state.preview?.page);
      if (last) show(...last);
    } catch {
      if (wanted === entering) flat("The 3-D view is not in this installation: run make studio-3d (it needs npm). Here is the arm from above.");
    } finally {
      if (wanted === entering) entering = null;
    }
    return undefined;
  };
  const flat = (/** @type {string} */ why) => {
    look("above");
    said.textContent = why;
  };
  const show = (/** @type {any} */ pen, /** @type {number} */ ink) => {
    last = [pen, ink];
    if (element.hidden || !plan) return;
    const q = plan.joints ? between(plan, pen) : robot.poses.safe;
    if (view === "above") above.show(q, ink);
    else space?.show(q, ink);
  };
  const setPlan = async (/** @type {any} */ next, /** @type {Lines} */ drawn) => {
    const name = app.state.robot;
    panel.hidden = !name;
    // A sheet that cannot be drawn on is shown too where it was given a place, the arm at rest beside it.
    [plan, lines] = [next?.base_from_paper ? next : null, drawn];
    if (!name || !plan) return look("sheet");
    if (robot?.name !== name) {
      const found = await ask(`api/robot/${name}.json`);
      // Another plan or arm came meanwhile.
      if (plan !== next || app.state.robot !== name) return undefined;
      robot = found;
      entering = null;
      space?.close();
      space = null;
      if (view === "sheet") view = "above";
    }
    above.setPlan(robot, plan, drawn, app.state.preview?.page);
    space?.setPlan({ ...plan, base: robot.base }, drawn, app.state.preview?.page);
    return look(view);
  };
  return { element, panel, show, plan: setPlan, close: () => ((entering = null), above.close(), space?.close()) };
}
