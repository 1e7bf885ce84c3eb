// What the person does goes in; the state that every screen shows comes out, kept in step with the server.

import { ask, Refused, sendPhoto, tell } from "./api.js";
import { Connection } from "./socket.js";
import { createStore } from "./store.js";
import { toast } from "./toast.js";

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {import("./ink.js").Page} Page */
/** @typedef {import("./landmarks.js").Point} Point */
/** @typedef {{photo: string, width: number, height: number, faces: any[], notes: string[], url: string, error?: string}} Photo */
/** @typedef {{lines: Lines, report: any, page: Page, rev: number, final: boolean}} Drawn */

const RECENT = 8;

/** Which drawings each screen needs. */
const WANTS = {
  photo: ["preview"],
  face: ["preview", "refinements"],
  choose: ["preview", "candidates"],
  adjust: ["preview"],
  watch: ["preview"],
  send: ["preview"],
};

const EMPTY = { preview: null, candidates: [], refinements: [], drawingError: "" };

/** The person's photo, face, settings and what became of them. */
export class App {
  /** @param {any} options what the server offers */
  constructor(options) {
    this.options = options;
    this.store = createStore({
      .../** @type {any} */ (EMPTY),
      screen: "photo", photo: null, face: 0, points: null, placing: false, settings: {}, loading: false, trouble: null,
      drawing: false, online: false, job: null, recents: [], revision: 0,
    });
    this.connection = new Connection("ws", {
      message: (message, frame) => this._received(message, frame),
      state: (online) => (this.set({ online }), online && this.wish()),
    });
  }

  /** @param {Record<string, any>} patch */
  set(patch) {
    this.store.set(patch);
  }

  get state() {
    return this.store.get();
  }

  /** @param {string} screen */
  go(screen) {
    if (location.hash !== `#${screen}`) location.hash = screen;
  }

  /** Called when a screen is shown: asks for what it needs and does not have. @param {string} screen */
  entered(screen) {
    this.set({ screen });
    const missing = { choose: !this.state.candidates.length, face: !this.state.refinements.length }[screen];
    if (missing || !this.state.preview?.final) this.wish();
  }

  /** Asks the server for drawings of what is set now. */
  wish() {
    const { photo, face, points, settings, screen, placing } = this.state;
    if (!photo || placing || !(photo.faces.length || points)) return;
    const want = WANTS[/** @type {keyof WANTS} */ (screen)] ?? ["preview"];
    const revision = this.connection.send({ photo: photo.photo, face, settings, points_px: points, want });
    const stale = { ...(want.includes("candidates") && { candidates: [] }), ...(want.includes("refinements") && { refinements: [] }) };
    this.set({ revision, drawing: true, drawingError: "", ...stale });
  }

  /** @param {Blob} blob */
  async upload(blob) {
    this.remember();
    this.set({ loading: true, trouble: null });
    this.go("photo");
    try {
      const found = await sendPhoto(blob);
      const photo = { ...found, url: `api/photo/${found.photo}.jpg` };
      this.set({ ...EMPTY, photo, face: 0, points: null, placing: false, trouble: found.error ? { text: found.error } : null, loading: false });
      if (photo.faces.length === 1) this.pickFace(0);
    } catch (error) {
      this.set({ loading: false, photo: null, trouble: { text: error instanceof Refused ? error.message : String(error) } });
    }
  }

  /** @param {number} face */
  pickFace(face) {
    this.set({ ...EMPTY, face, points: null, placing: false, trouble: null });
    this.wish();
    this.go("choose");
  }

  /** Goes on without a face that was found: the person says where it is. */
  placeByHand() {
    this.set({ ...EMPTY, placing: true, points: null, trouble: null });
    this.go("face");
  }

  /** Landmarks by hand, or null for those that were found. @param {Point[] | null} points */
  setPoints(points) {
    this.set({ points, placing: false, candidates: [] });
    this.wish();
  }

  /** @returns {Point[] | null} the landmarks that are drawn by */
  get landmarks() {
    const { points, preview, photo, face } = this.state;
    return points ?? preview?.report.points_px ?? photo?.faces[face]?.points_px ?? null;
  }

  /** @param {Record<string, any>} settings */
  setSettings(settings) {
    this.set({ settings, candidates: [] });
    this.wish();
  }

  /** Takes a candidate as the drawing; the others stay where they lie. @param {any} candidate */
  choose({ settings }) {
    const { candidates } = this.state;
    const screen = this.state.screen;
    const chosen = { ...this.state.settings, style: this.usual("style"), refine: this.usual("refine"), ...settings };
    this.set({ settings: chosen, screen: "adjust" });
    this.wish();
    this.set({ candidates, screen });
  }

  /** Some settings changed; undefined takes one back. @param {Record<string, any>} changes */
  change(changes) {
    const settings = { ...this.state.settings, ...changes };
    for (const [path, value] of Object.entries(changes)) if (value === undefined) delete settings[path];
    this.setSettings(settings);
  }

  /** A setting as it is now. @param {string} path */
  value(path) {
    const { settings } = this.state;
    return path in settings ? settings[path] : this.usual(path);
  }

  /** Its default. @param {string} path */
  usual(path) {
    return this.options.settings.find((/** @type {any} */ setting) => setting.path === path)?.default;
  }

  /** Keeps the drawing on the desk among the recent ones of this run. */
  remember() {
    const { photo, face, points, settings, preview, recents } = this.state;
    if (!photo || !preview) return;
    const others = recents.filter((/** @type {any} */ recent) => recent.photo.photo !== photo.photo || recent.face !== face);
    this.set({ recents: [{ photo, face, points, settings, lines: preview.lines, page: preview.page }, ...others].slice(0, RECENT) });
  }

  /** @param {any} recent */
  recall({ photo, face, points, settings }) {
    this.remember();
    this.set({ ...EMPTY, photo, face, points, settings, placing: false, trouble: null });
    this.wish();
    this.go("adjust");
  }

  /** @param {any} message @param {import("./frames.js").Frame | null} frame */
  _received(message, frame) {
    if (message.type === "job") return this.set({ job: message });
    if (message.type === "error") return this._failed(message);
    if (message.rev > this.state.revision || message.rev < this._least(message)) return undefined;
    const drawn = frame && drawnFrom(message, frame);
    if (message.type === "preview") this.set({ preview: drawn, drawing: !message.final, drawingError: "" });
    else this._variant(message, drawn);
    return undefined;
  }

  /** A preview that is late is still newer than what is shown; of candidates only the latest count. @param {any} message */
  _least(message) {
    const { preview, revision } = this.state;
    return message.type === "preview" ? preview?.rev ?? 0 : revision;
  }

  /** @param {any} message @param {Drawn | null} drawn */
  _variant(message, drawn) {
    const key = message.type === "candidate" ? "candidates" : "refinements";
    const list = this.state[key].slice();
    list[message.place] = { ...message, ...drawn };
    list.length = message.of;
    this.set({ [key]: list });
  }

  /** @param {any} message */
  _failed({ error, rev }) {
    if (rev !== undefined && rev !== this.state.revision) return;
    this.set({ drawing: false, drawingError: error });
  }

  /** Sends a command about the machine. @param {string} path @param {any} value */
  async command(path, value) {
    try {
      return await tell(path, value);
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error));
      return null;
    }
  }
}

/** @param {any} message @param {import("./frames.js").Frame} frame @returns {Drawn} */
function drawnFrom(message, frame) {
  const { report } = message;
  const page = { ...report.page, pen_mm: report.pen_mm };
  return { lines: frame.lines, report, page, rev: message.rev, final: Boolean(message.final) };
}

/** @returns {Promise<App>} */
export async function connect() {
  return new App(await ask("api/options"));
}
