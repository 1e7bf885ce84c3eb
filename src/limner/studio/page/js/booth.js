// A guest goes in by a touch: countdown, photo, three candidates, a number in the queue; then the next guest.

import { ask, sendPhoto, tell } from "./api.js";
import { Camera, cameraTrouble, countdown } from "./camera.js";
import { h } from "./dom.js";
import { duration } from "./format.js";
import { pageOf } from "./ink.js";
import { Sheet } from "./sheet.js";
import { Connection } from "./socket.js";
import { specimen } from "./specimen.js";

/** @typedef {{countdown_s: number, reset_s: number, ticket_s: number, candidates: number}} Rules */
/** @typedef {{photo: string, candidates: any[], rev: number, entry: string}} Guest */

const main = /** @type {HTMLElement} */ (document.getElementById("main"));

/** The booth: one scene at a time; whoever goes away is forgotten. */
class Booth {
  /** @param {Rules} rules */
  constructor(rules) {
    this.rules = rules;
    this.forget();
    /** @type {any[]} the queue as it was told last */
    this.line = [];
    /** @type {() => void} */
    this.leaveScene = () => {};
    this.connection = new Connection("ws", { message: (message, frame) => this.heard(message, frame), state: () => {} });
    for (const sign of ["pointerdown", "keydown"]) addEventListener(sign, () => this.stillHere());
  }

  forget() {
    /** @type {Guest} */
    this.guest = { photo: "", candidates: [], rev: 0, entry: "" };
  }

  /** @param {string} name of the scene @param {HTMLElement} element @param {() => void} [leave] */
  show(name, element, leave = () => {}) {
    this.leaveScene();
    this.leaveScene = leave;
    this.scene = name;
    main.replaceChildren(element);
    main.focus({ preventScroll: true });
    this.stillHere();
  }

  /** Starts the clock anew after which an idle booth begins again. */
  stillHere() {
    clearTimeout(this.idle);
    if (this.scene === "begin") return;
    const seconds = this.scene === "ticket" ? this.rules.ticket_s : this.rules.reset_s;
    this.idle = setTimeout(() => this.leave(), 1000 * seconds);
  }

  async leave() {
    this.forget();
    this.begin();
    await tell("api/leave", {}).catch(() => {});
  }

  begin() {
    const drawing = specimen("A portrait in few pen strokes");
    const start = h("button", { type: "button", class: "primary", onclick: () => this.photograph() }, "Touch to be drawn");
    this.show("begin", h("div", { class: "scene begin" }, h("div", { class: "paper" }, drawing.element), h("h1", {}, "Your face, in a few lines"), start,
      h("p", { class: "privacy" }, "Your photo is forgotten when you leave. Only the drawing is kept, until it is drawn.")), drawing.close);
  }

  photograph() {
    const camera = new Camera();
    const stop = new AbortController();
    const hint = h("p", { class: "hint" }, "Look here");
    const element = h("div", { class: "scene camera" }, h("h1", { class: "out-of-sight" }, "Your photo"), camera.video, hint);
    this.show("camera", element, () => (stop.abort(), camera.stop()));
    camera.start().then(async () => {
      if (stop.signal.aborted) return camera.stop();
      if (!(await countdown(element, this.rules.countdown_s, stop.signal))) return undefined;
      const photo = await camera.photo();
      element.append(h("img", { src: URL.createObjectURL(photo), alt: "Your photo" }), h("div", { class: "flash" }));
      return this.look(photo);
    }).catch((error) => this.again(cameraTrouble(error)));
  }

  /** @param {Blob} photo */
  async look(photo) {
    this.show("look", h("div", { class: "scene", role: "status" }, h("span", { class: "spinner" }), h("h1", {}, "Looking at you…")));
    try {
      const found = await sendPhoto(photo);
      if (!found.faces.length) return this.again("I could not see your face. Come closer, and look straight at me.");
      this.guest.photo = found.photo;
      this.guest.rev = this.connection.send({ photo: found.photo, face: 0, settings: {}, points_px: null, want: ["candidates"] });
      return this.choose();
    } catch (error) {
      return this.again(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {string} why */
  again(why) {
    this.show("again", h("div", { class: "scene" }, h("h1", {}, "Once more?"), h("p", { class: "lead", role: "alert" }, why),
      h("div", { class: "row" }, h("button", { type: "button", class: "primary", onclick: () => this.photograph() }, "Once more"), h("button", { type: "button", onclick: () => this.leave() }, "Leave"))));
  }

  choose() {
    const { candidates } = this.rules;
    this.places = Array.from({ length: candidates }, () => h("li", {}, h("div", { class: "card" }, h("div", { class: "paper waiting" }, h("span", { class: "spinner" })))));
    const element = h("div", { class: "scene" }, h("h1", {}, "Which one is you?"), h("ul", { class: "three" }, this.places),
      h("div", { class: "row" }, h("button", { type: "button", onclick: () => this.photograph() }, "Another photo"), h("button", { type: "button", onclick: () => this.leave() }, "Leave")));
    this.show("choose", element, () => this.guest.candidates.forEach(({ sheet }) => sheet.close()));
  }

  /** @param {any} message @param {import("./frames.js").Frame | null} frame */
  heard(message, frame) {
    if (message.type === "queue") return this.queued((this.line = message.queue));
    if (this.scene !== "choose" || message.rev !== this.guest.rev) return undefined;
    if (message.type === "error") return this.again(message.error);
    if (message.type === "candidate" && frame?.lines) this.offer(message, frame.lines);
    return undefined;
  }

  /** @param {any} message @param {import("./ink.js").Lines} lines */
  offer(message, lines) {
    const place = this.places?.[this.guest.candidates.length];
    if (!place) return;
    const sheet = new Sheet({ bare: true, label: message.label });
    sheet.show(lines, pageOf(message.report));
    this.guest.candidates.push({ sheet });
    place.replaceChildren(h("button", { type: "button", class: "card", onclick: () => this.take(message) },
      h("span", { class: "paper" }, sheet.element), h("span", { class: "name" }, duration(message.report.seconds))));
  }

  /** @param {any} candidate */
  async take({ settings }) {
    const { photo } = this.guest;
    this.show("take", h("div", { class: "scene", role: "status" }, h("span", { class: "spinner" }), h("h1", {}, "A moment…")));
    try {
      const { drawing } = await tell("api/drawing", { photo, face: 0, points_px: null, settings });
      const entry = await tell("api/queue", { drawing });
      this.guest.entry = entry.entry;
      this.ticket(entry);
    } catch (error) {
      this.again(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {any} entry */
  ticket(entry) {
    this.number = h("p", { class: "ticket" });
    this.wait = h("p", { class: "lead", role: "status" });
    this.show("ticket", h("div", { class: "scene" }, h("h1", {}, "You are in the queue"), this.number, this.wait, h("button", { type: "button", class: "primary", onclick: () => this.leave() }, "Done")));
    this.queued([entry]);
    // What became of it may have been told before the answer came that it waits.
    this.queued(this.line);
  }

  /** What has become of the guest's drawing. @param {any[]} queue */
  queued(queue) {
    const mine = queue.find(({ entry }) => entry === this.guest.entry);
    if (this.scene !== "ticket" || !mine || !this.number || !this.wait) return;
    this.number.textContent = mine.state === "waiting" ? String(mine.place) : "✓";
    this.wait.textContent = { waiting: `About ${duration(mine.left_s)} until it is done.`, drawing: "It is being drawn now.", done: "It is drawn. Take it with you!" }[/** @type {"done"} */ (mine.state)] ?? "It was skipped. Ask whoever looks after the machine.";
  }
}

ask("api/booth").then((rules) => {
  const booth = new Booth(rules);
  Object.assign(globalThis, { limnerApp: booth });
  booth.begin();
}, (error) => main.replaceChildren(h("div", { class: "scene" }, h("h1", {}, "Not now"), h("p", { class: "lead", role: "alert" }, error.message))));
