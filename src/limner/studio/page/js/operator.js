// The booth's queue and machine go in; the page of whoever looks after them comes out.

import { ask, tell } from "./api.js";
import { h, put } from "./dom.js";
import { duration } from "./format.js";
import { decode } from "./frames.js";
import { busy } from "./job.js";
import { goalPart } from "./parts/goal.js";
import { jobPart } from "./parts/job.js";
import { A5, Sheet } from "./sheet.js";
import { Connection } from "./socket.js";
import { createStore } from "./store.js";
import { themeButton } from "./theme.js";
import { toast } from "./toast.js";

const main = /** @type {HTMLElement} */ (document.getElementById("main"));
const WORDS = new Map([["waiting", "waits"], ["drawing", "is being drawn"], ["done", "drawn"], ["skipped", "skipped"]]);

/** The operator's page. */
class Operator {
  constructor() {
    this.store = createStore(/** @type {any} */ ({ queue: [], held: false, job: null, to: "", machine: null, robot: null }));
    /** @type {Map<string, Sheet>} */
    this.sheets = new Map();
    this.job = jobPart(/** @type {any} */ (this), "api/operator");
    main.replaceChildren(this.page());
    this.store.watch(["queue"], () => this.list());
    this.store.watch(["job", "held", "queue"], () => this.desk());
    this.connection = new Connection("ws/operator", { message: ({ type, ...more }) => this.heard(type, more), state: (open) => open && this.load() });
  }

  /** @param {any} patch */
  set(patch) {
    this.store.set(patch.queue ? patch : patch.job ?? patch);
  }

  /** @param {string} type @param {any} more */
  heard(type, more) {
    if (type === "job") this.store.set({ job: more });
    if (type === "queue") this.store.set(more);
  }

  async load() {
    const told = await ask("api/operator/queue");
    this.store.set(told);
    await this.goal?.show(told);
  }

  /** @param {string} path @param {any} [value] */
  async command(path, value = {}) {
    try {
      const told = await tell(path, value);
      this.store.set(told);
      return told;
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error));
      return null;
    }
  }

  page() {
    const theme = h("button", { type: "button", class: "icon plain" });
    themeButton(theme);
    this.entries = h("ul", { class: "entries" });
    this.count = h("p", { class: "quiet", role: "status" });
    this.next = h("button", { type: "button", class: "primary", onclick: () => this.command("api/operator/next") }, "Begin the next");
    this.skip = h("button", { type: "button", onclick: () => this.command("api/operator/skip") }, "Skip this one");
    this.hold = h("button", { type: "button", onclick: () => this.command(`api/operator/${this.store.get().held ? "release" : "hold"}`) });
    this.goal = goalPart((goal) => this.command("api/operator/target", goal).then((told) => told && toast(`The next is drawn at ${told.to}.`)));
    return h("div", {}, h("header", { class: "row apart" }, h("h1", {}, "The booth's queue"), theme), this.count,
      h("div", { class: "columns" }, h("section", { "aria-label": "Queue" }, this.entries),
        h("div", { class: "desk" }, this.job.element, h("div", { class: "row" }, this.next, this.skip, this.hold), this.goal.element)));
  }

  desk() {
    const { job, held, queue } = this.store.get();
    if (job) this.job.show(job);
    const waiting = queue.filter((/** @type {any} */ entry) => entry.state === "waiting").length;
    this.next.disabled = busy(job) || !waiting;
    this.skip.disabled = !queue.some((/** @type {any} */ entry) => entry.state === "drawing");
    this.hold.textContent = held ? "Let the queue run" : "Wait for me before each";
    put(this.hold, "aria-pressed", String(Boolean(held)));
  }

  list() {
    const { queue } = this.store.get();
    const waiting = queue.filter((/** @type {any} */ entry) => entry.state === "waiting");
    this.count.textContent = waiting.length ? `${waiting.length} in the queue, ${duration(waiting.at(-1).left_s)} until the last is done.` : "Nobody waits.";
    this.entries.replaceChildren(...queue.map((/** @type {any} */ entry) => this.entry(entry)));
  }

  /** @param {any} entry */
  entry({ entry, name, state, place, left_s }) {
    const away = h("button", { type: "button", "aria-label": `Take out ${name || place}`, onclick: () => this.command("api/operator/remove", { entry }) }, "Take out");
    return h("li", {}, h("span", { class: "place" }, state === "waiting" ? place : state === "done" ? "✓" : "·"), h("span", { class: "paper" }, this.sheet(entry).element),
      h("span", {}, h("b", {}, name || "A guest"), h("span", { class: "small quiet" }, ` ${WORDS.get(state) ?? state}${state === "waiting" ? `, done in ${duration(left_s)}` : ""}`)), state === "drawing" ? null : away);
  }

  /** A small sheet with the drawing, fetched once. @param {string} entry */
  sheet(entry) {
    let sheet = this.sheets.get(entry);
    if (!sheet) {
      sheet = new Sheet({ bare: true, label: "Drawing" });
      this.sheets.set(entry, sheet);
      fetch(`api/operator/drawing/${entry}.lines`).then(async (answer) => {
        const { lines } = answer.ok ? decode(await answer.arrayBuffer()) : {};
        if (lines) sheet?.show(lines, A5);
      });
    }
    return sheet;
  }
}

Object.assign(globalThis, { limnerApp: new Operator() });
