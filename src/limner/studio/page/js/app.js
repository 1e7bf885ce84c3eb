// What the person does goes in; the state that every screen shows comes out, kept in step with the server.

import { answers, ask, download, photoUrl, Refused, sendPhoto, tell } from "./api.js";
import { pageOf } from "./ink.js";
import { recentDrawings } from "./recent.js";
import { Connection } from "./socket.js";
import { createStore } from "./store.js";
import { toast } from "./toast.js";

/** @typedef {import("./ink.js").Lines} Lines */
/** @typedef {import("./ink.js").Page} Page */
/** @typedef {import("./landmarks.js").Point} Point */
/** @typedef {{photo: string, width: number, height: number, faces: any[], notes: string[], url: string, error?: string}} Photo */
/** @typedef {{lines: Lines, report: any, page: Page, rev: number, final: boolean}} Drawn */

/** Which drawings each screen needs. */
const WANTS = {
  photo: ["preview"],
  face: ["preview", "refinements"],
  choose: ["preview", "candidates"],
  adjust: ["preview"],
  watch: ["preview", "plan"],
  send: ["preview", "plan"],
};

const EMPTY = { preview: null, candidates: [], refinements: [], drawingError: "", found: null, plan: null, planError: "" };

/** The person's photo, face, settings and what became of them. */
export class App {
  /** @param {any} options what the server offers */
  constructor(options) {
    this.options = options;
    this.store = createStore({
      .../** @type {any} */ (EMPTY),
      screen: "photo", photo: null, face: 0, points: null, placing: false, settings: {}, loading: false, trouble: null,
      drawing: false, online: false, stranger: false, job: null, queue: null, robot: "", recents: [], revision: 0,
    });
    /** @type {Point[] | null} the landmarks of the last wish, and the first wish that had them */
    this.wished = null;
    this.pointsRevision = 0;
    /** @type {{same: string, kept: any} | null} the drawing that the server keeps */
    this.kept = null;
    /** @type {string[]} what the last wish wanted */
    this.wanted = [];
    /** @type {{photo: string, blob: Blob} | null} a photo's file, for a server that is started again */
    this.file = null;
    this.uploads = 0;
    this.connection = new Connection("ws", {
      message: (message, frame) => this._received(message, frame),
      state: (online) => (online ? this._online() : this._offline()),
    });
  }

  /** A server that was started again has forgotten the photo: it gets it once more, and all goes on as it was set. */
  async _online() {
    this.set({ online: true, stranger: false });
    const { photo } = this.state;
    if (photo && this.file?.photo === photo.photo && !(await answers(photo.url))) {
      const found = await sendPhoto(this.file.blob).catch(() => null);
      if (found) this._hold(found, this.file.blob);
    }
    this.wish();
  }

  /** Tells a server that is away from one that was started again and does not know this browser. */
  async _offline() {
    this.set({ online: false });
    const refused = await ask("api/job").then(() => 0, (error) => error.status);
    // An answer that is late says nothing of a server that is back.
    if (!this.state.online) this.set({ stranger: refused === 401 });
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
    const { candidates, refinements, plan } = this.state;
    const missing = { choose: !complete(candidates), face: !complete(refinements), watch: !plan, send: !plan }[screen];
    if (missing || !this.state.preview?.final) this.wish();
  }

  /** Asks the server for drawings of what is set now. @param {string[]} [only] instead of what the screen needs */
  wish(only) {
    const { photo, face, points, settings, screen, placing } = this.state;
    if (!photo || placing || !(photo.faces.length || points)) return;
    const want = only ?? WANTS[/** @type {keyof WANTS} */ (screen)] ?? ["preview"];
    const revision = this.connection.send({ photo: photo.photo, face, settings, points_px: points, want, ...(want.includes("plan") && { plan: this.drawer }) });
    const stale = { ...(want.includes("plan") && { plan: null, planError: "" }), ...(want.includes("candidates") && { candidates: [] }), ...(want.includes("refinements") && { refinements: [] }) };
    if (points !== this.wished) this.pointsRevision = revision;
    this.wished = points;
    this.wanted = want;
    this.set({ revision, drawing: true, drawingError: "", ...stale });
  }

  /** @param {Blob} blob */
  async upload(blob) {
    this.remember();
    this.set({ loading: true, trouble: null });
    this.go("photo");
    const mine = (this.uploads += 1);
    try {
      const found = await sendPhoto(blob);
      // Of two photos given one after the other the last counts, whichever is looked at sooner.
      if (mine !== this.uploads) return;
      const photo = this._hold(found, blob);
      this.set({ ...EMPTY, face: 0, points: null, placing: false, trouble: found.error ? { text: found.error } : null, loading: false });
      if (photo.faces.length === 1) this.pickFace(0);
    } catch (error) {
      if (mine === this.uploads) this.set({ loading: false, photo: null, trouble: { text: error instanceof Refused ? error.message : String(error) } });
    }
  }

  /** @param {any} found @param {Blob} blob @returns {Photo} */
  _hold(found, blob) {
    const photo = { ...found, url: photoUrl(found) };
    this.file = { photo: photo.photo, blob };
    this.set({ photo });
    return photo;
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
    this.set({ points, placing: false, candidates: [], plan: null });
    this.wish();
  }

  /** @returns {Point[] | null} the landmarks that are drawn by */
  get landmarks() {
    const { points, found, photo, face } = this.state;
    return points ?? found ?? photo?.faces[face]?.points_px ?? null;
  }

  /** @param {Record<string, any>} settings */
  setSettings(settings) {
    this.set({ settings, candidates: [], plan: null });
    this.wish();
  }

  /** Takes a candidate as the drawing; the others stay where they lie, and those that are not there yet still come. @param {any} candidate */
  choose({ settings }) {
    const { candidates } = this.state;
    this.set({ settings: { ...this.state.settings, ...settings }, plan: null });
    this.wish(complete(candidates) ? ["preview"] : WANTS.choose);
    this.set({ candidates });
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

  /** Has the server keep the drawing on the desk, among the recent ones of this run. */
  async remember() {
    const { photo, preview } = this.state;
    if (photo && preview && (await this.keep())) await this.recollect();
  }

  /** The drawings that the server keeps: they outlast a reload, and end with limner. */
  async recollect() {
    this.set({ recents: await recentDrawings(this.state.recents) });
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
    if (message.type === "queue") return this.set({ queue: message });
    if (message.type === "error") return this._failed(message);
    if (message.rev > this.state.revision || message.rev < this._least(message)) return undefined;
    if (message.type === "plan") return this.set({ plan: { ...message.plan, joints_named: message.plan?.joints, joints: undefined, ...frame?.plan }, planError: message.error ?? "" });
    const drawn = frame && drawnFrom(message, frame);
    if (message.type === "preview") this._previewed(message, drawn);
    else this._variant(message, drawn);
    return undefined;
  }

  /** @param {any} message @param {Drawn | null} drawn */
  _previewed(message, drawn) {
    const placed = this.state.points === null && message.rev >= this.pointsRevision;
    this.set({ preview: drawn, drawing: !message.final, drawingError: "", ...(placed && { found: message.report.points_px }) });
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
    // One that lies there already is the same.
    if (list[message.place]?.name !== message.name) list[message.place] = { ...message, ...drawn };
    list.length = message.of;
    this.set({ [key]: list, ...(message.place === message.of - 1 && { drawing: false }) });
  }

  /** @param {any} message */
  _failed({ error, rev }) {
    if (rev !== undefined && rev !== this.state.revision) return;
    // What cannot be drawn one way may be drawn another.
    if (this.wanted.includes("candidates") && this.wanted.length > 1) {
      this.wish(["candidates"]);
      return;
    }
    this.set({ drawing: false, drawingError: error });
  }

  /** Has the server keep the drawing as it is set now, and tells its name. @returns {Promise<any>} */
  async keep() {
    const { photo, face, points, settings } = this.state;
    const wish = { photo: photo.photo, face, points_px: points, settings };
    const same = JSON.stringify(wish);
    if (this.kept?.same !== same) {
      const kept = await this.command("api/drawing", wish);
      this.kept = kept && { same, kept };
    }
    return this.kept?.kept ?? null;
  }

  /** Saves the drawing as a file. @param {string} format @param {string} [query] @returns {Promise<boolean>} */
  async save(format, query = "") {
    const kept = await this.keep();
    if (!kept) return false;
    try {
      await download(`api/export/${kept.drawing}.${format}${query}`, `portrait.${format}`);
      return true;
    } catch (error) {
      toast(error instanceof Error ? error.message : String(error));
      return false;
    }
  }

  /** Whether a style makes a picture in colours too. @param {string} style */
  pictured(style) {
    return this.options.styles.some((/** @type {any} */ { name, picture }) => picture && name === style);
  }

  /** Who is to draw: a machine by its name, or an arm. @returns {{machine: string} | {robot: string}} */
  get drawer() {
    return this.state.robot ? { robot: this.state.robot } : { machine: this.value("machine") };
  }

  /** Another arm, or none: a plotter draws. @param {string} robot */
  setRobot(robot) {
    this.set({ robot, plan: null, planError: "" });
    this.wish();
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

/** Whether all of them are there: they come one by one. @param {any[]} variants */
function complete(variants) {
  return variants.length > 0 && !Array.from(variants).includes(undefined);
}

/** @param {any} message @param {import("./frames.js").Frame} frame @returns {Drawn} */
function drawnFrom(message, frame) {
  const { report } = message;
  return { lines: frame.lines, report, page: pageOf(report), rev: message.rev, final: Boolean(message.final) };
}

/** @returns {Promise<App>} */
export async function connect() {
  return new App(await ask("api/options"));
}
