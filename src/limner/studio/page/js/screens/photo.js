// The first screen: a photo comes in by dropping, choosing, pasting or the camera; several faces: one is chosen.

import { cameraView } from "../camera.js";
import { h, icon, ICONS } from "../dom.js";
import { plural, sentence } from "../format.js";
import { specimen } from "../specimen.js";
import { recentList } from "../parts/recents.js";

const ACCEPTED = "image/*,.heic,.heif";

const NO_FACE = "limner looks for a face that is turned to the camera. More light, a step closer and a look into the lens help. Or show it where the face is.";

/** @typedef {import("../app.js").App} App */
/** @typedef {{element: HTMLElement, close: () => void}} View */

/**
 * @param {App} app
 * @returns {View}
 */
export function photoScreen(app) {
  const easel = h("div", { class: "easel" });
  const talk = h("div", { class: "stack" });
  const recents = recentList(app);
  const element = h("div", { class: "welcome screen" }, h("div", { class: "stack" }, talk, privacy(), recents.element), easel);
  /** @type {View | null} */
  let shown = null;

  const show = (/** @type {View} */ view) => {
    shown?.close();
    shown = view;
    easel.replaceChildren(view.element);
  };
  const camera = () =>
    show(cameraView({
      keep: (photo) => app.upload(photo),
      leave: rest,
      fail: (text) => (rest(), app.set({ trouble: { text } })),
    }));
  const rest = () => show(app.state.photo && !app.state.loading ? facesView(app, app.state.photo) : example());
  const input = h("input", { type: "file", accept: ACCEPTED, hidden: true, onchange: () => input.files[0] && app.upload(input.files[0]) });
  const refresh = () => {
    const { photo, loading, trouble } = app.store.get();
    talk.replaceChildren(...words(app, { choose: () => input.click(), camera }), input);
    if (loading) return;
    if (photo && (trouble || photo.faces.length !== 1)) show(facesView(app, photo));
    else if (!shown || trouble) rest();
  };
  const stop = app.store.watch(["photo", "loading", "trouble", "face"], refresh);
  return { element, close: () => (stop(), recents.close(), shown?.close()) };
}

/** @returns {View} */
function example() {
  const drawing = specimen("A portrait in few pen strokes, drawn by limner");
  const paper = h("div", { class: "paper" }, drawing.element);
  return { element: paper, close: drawing.close };
}

function privacy() {
  return h("div", { class: "privacy small quiet" }, icon(ICONS.lock),
    h("p", {}, "Your photo stays on this computer, in its memory. When limner ends, it and every drawing are gone, unless you save them."));
}

/**
 * @param {App} app
 * @param {{choose: () => void, camera: () => void}} how
 */
function words(app, how) {
  const { photo, loading, trouble } = app.store.get();
  const actions = h("div", { class: "actions" },
    h("button", { type: "button", class: "primary", onclick: how.choose, disabled: loading }, icon(ICONS.upload), "Choose a photo"),
    h("button", { type: "button", onclick: how.camera, disabled: loading }, icon(ICONS.camera), "Use the camera"));
  if (loading) return [h("h1", {}, "Looking for the face…"), h("div", { class: "row", role: "status" }, h("span", { class: "spinner" }), h("p", { class: "lead" }, "This takes a moment."))];
  const faceless = photo && !photo.faces.length;
  if (trouble) return [h("h1", {}, faceless ? "No face found" : "That did not work"), troubleNote(app, trouble, faceless), actions];
  if (photo?.faces.length === 1) {
    return [h("h1", {}, "Your photo"), h("p", { class: "lead" }, "Go on with it, or give limner another one."), actions, h("div", { class: "row" }, h("a", { class: "button", href: "#face" }, "Go on with this one"))];
  }
  if (photo && photo.faces.length > 1) {
    return [h("h1", {}, "Who is it to be?"), h("p", { class: "lead" }, `There are ${plural(photo.faces.length, "face")} in this photo. Choose one.`), actions];
  }
  return [
    h("h1", {}, "A face, in a few lines."),
    h("p", { class: "lead" }, "Give limner a photo. It finds the lines that make the person, and a plotter or a robot arm draws them."),
    actions,
    h("p", { class: "quiet small" }, "Or drop a photo anywhere, or paste one."),
  ];
}

/** @param {App} app @param {{text: string}} trouble @param {boolean} faceless */
function troubleNote(app, trouble, faceless) {
  const byHand = h("button", { type: "button", onclick: () => app.placeByHand() }, "Place the landmarks by hand");
  return h("div", { class: "note bad", role: "alert" }, h("p", {}, faceless ? NO_FACE : sentence(trouble.text)), faceless && h("div", { class: "row" }, byHand));
}

/**
 * The photo, and a button over each face; a single one is chosen already, and perhaps its landmarks were moved.
 * @param {App} app
 * @param {any} photo
 * @returns {View}
 */
function facesView(app, photo) {
  const picture = h("img", { src: photo.url, alt: "Your photo", width: photo.width, height: photo.height });
  const faces = h("div", { class: "faces", role: "group", "aria-label": "Faces" });
  photo.faces.forEach((/** @type {any} */ face, /** @type {number} */ i) => {
    const [x0, y0, x1, y1] = face.box_px;
    const button = h("button", { type: "button", onclick: () => app.pickFace(i) }, h("span", {}, `Face ${i + 1}`));
    const share = (/** @type {number} */ part, /** @type {number} */ whole) => `${Math.min(Math.max((100 * part) / whole, 0), 100)}%`;
    Object.assign(button.style, { left: share(x0, photo.width), top: share(y0, photo.height), width: share(x1 - x0, photo.width), height: share(y1 - y0, photo.height) });
    faces.append(button);
  });
  return { element: h("div", { class: "paper wide" }, picture, photo.faces.length > 1 && faces), close: () => {} };
}
