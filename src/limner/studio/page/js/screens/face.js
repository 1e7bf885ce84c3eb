// The second screen: the landmarks over the photo, to be moved by hand, and what each correction does to them.

import { tell } from "../api.js";
import { h, icon, ICONS } from "../dom.js";
import { COLOURS, Editor } from "../editor.js";
import { History } from "../history.js";
import { ANCHORS, carried, COUNT, KEYS, meanShift } from "../landmarks.js";
import { notes } from "../parts/notes.js";
import { toast } from "../toast.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../landmarks.js").Point} Point */

const ABOUT = new Map([
  ["none", "As they were found"], ["best", "The learnt correction (usual)"], ["brows", "Brows"], ["jaw-gradient", "Jaw, by gradient"],
  ["jaw-outliers", "Jaw, outliers"], ["jaw-spline", "Jaw, by spline"], ["eye-corners", "Corners of the eyes"], ["shape", "Nearer to the average face"],
]);

/** @param {App} app */
export function faceScreen(app) {
  return app.state.placing ? placing(app) : editing(app);
}

/** @param {App} app */
function editing(app) {
  const { photo } = app.state;
  let history = new History(/** @type {Point[]} */ (app.landmarks ?? []));
  const said = h("p", { class: "small quiet number", role: "status" }, "Pick a landmark to move it.");
  const editor = new Editor(photo, {
    changed: (points) => keep(points),
    picked: (text) => (said.textContent = text),
    undo: () => go(history.undo()),
    redo: () => go(history.redo()),
  });
  const buttons = {
    undo: tool("Undo", ICONS.undo, () => go(history.undo())),
    redo: tool("Redo", ICONS.redo, () => go(history.redo())),
  };
  const corrections = h("ul", { class: "picks" });
  /** @type {Map<any, {view: HTMLElement, tell: () => void}>} */
  let rows = new Map();
  const keep = (/** @type {Point[]} */ points) => (history.push(points), go(points));
  const go = (/** @type {Point[]} */ points) => {
    editor.show(points);
    buttons.undo.disabled = !history.canUndo;
    buttons.redo.disabled = !history.canRedo;
    app.setPoints(history.at === 0 && !app.state.photo.byHand ? null : points);
  };
  const stop = app.store.watch(["found", "refinements"], ({ found, points, refinements }) => {
    // What was corrected by the server is where undo ends.
    if (!points && found && history.versions.length === 1 && !editor.drag) {
      history = new History(found);
      editor.show(found);
    }
    // A row that is there stays: somebody may be about to click it.
    rows = new Map(refinements.filter(Boolean).map((/** @type {any} */ refinement) => [refinement, rows.get(refinement) ?? correction(editor, () => history.present, refinement, keep)]));
    corrections.append(...[...rows.values()].map(({ view }) => view).filter((view) => view.parentNode !== corrections));
    for (const view of [...corrections.children]) if (![...rows.values()].some((row) => row.view === view)) view.remove();
    rows.forEach(({ tell }) => tell());
  });
  buttons.undo.disabled = buttons.redo.disabled = true;
  if (history.present.length === COUNT) editor.show(history.present);
  const reset = h("button", { type: "button", onclick: () => (history.push(history.first), app.setPoints(null), editor.show(history.first), (buttons.undo.disabled = false)) }, "Reset all");
  const panel = [
    h("section", {}, h("h1", {}, "The face"), h("p", { class: "quiet" }, "Lines are looked for where these points are. If one is off, move it."), said,
      h("div", { class: "row" }, reset, h("button", { type: "button", onclick: () => app.placeByHand() }, "Place anew"))),
    regions(editor),
    h("section", { "aria-labelledby": "corrections" }, h("h2", { id: "corrections" }, "Corrections"),
      h("p", { class: "small quiet" }, "Point at one to see it dashed over the photo; click to take it."), corrections),
    help(),
    h("section", {}, h("a", { class: "button primary", href: "#choose" }, "See the drawings")),
  ];
  return screen(app, editor, [buttons.undo, buttons.redo], panel, () => stop());
}

/** A template is laid over the face by its eyes and chin. @param {App} app */
function placing(app) {
  const { photo } = app.state;
  const said = h("p", { class: "small quiet number", role: "status" }, "");
  const editor = new Editor(photo, { changed: () => {}, picked: (text) => (said.textContent = text), undo: () => {}, redo: () => {} });
  editor.movable = (index) => ANCHORS.includes(index);
  editor.moving = (index, to) => {
    const from = ANCHORS.map((anchor) => editor.points[anchor]);
    return carried(editor.points, from, ANCHORS.map((anchor, i) => (anchor === index ? to : from[i])));
  };
  const half = 0.28 * Math.min(photo.width, photo.height);
  const [x, y] = [photo.width / 2, photo.height * 0.45];
  const box = photo.faces[app.state.face]?.box_px ?? [x - half, y - half, x + half, y + half];
  tell(`api/photo/${photo.photo}/face`, { box_px: box }).then(
    ({ face }) => (editor.show(face.points_px), editor.frame(), editor.zoom(0.55)),
    (error) => toast(error.message),
  );
  const done = () => {
    photo.byHand = true;
    app.setPoints(editor.points);
    app.go("choose");
  };
  const panel = [
    h("section", {}, h("h1", {}, "Show me the face"),
      h("p", { class: "quiet" }, "Drag the three large points: the outer corner of each eye, and the chin. The others follow."), said,
      h("div", { class: "row" }, h("button", { type: "button", class: "primary", onclick: done }, "That is the face"),
        h("a", { class: "button", href: "#photo" }, "Another photo"))),
    help(),
  ];
  return screen(app, editor, [], panel, () => {});
}

/** @param {App} app @param {Editor} editor @param {HTMLElement[]} tools @param {any[]} panel @param {() => void} stop */
function screen(app, editor, tools, panel, stop) {
  const bar = h("div", { class: "tools-over", role: "toolbar", "aria-label": "View" }, tools,
    tool("Smaller", ICONS.minus, () => editor.zoom(0.8)), tool("Larger", ICONS.plus, () => editor.zoom(1.25)), tool("The whole face", ICONS.fit, () => editor.frame()));
  const view = h("div", { class: "view" }, editor.element, h("div", { class: "overlay" }, notes(app)), bar);
  const element = h("div", { class: "split screen" }, h("div", { class: "stage" }, view), h("div", { class: "panel" }, panel));
  Object.assign(globalThis, { limnerEditor: editor });
  return { element, close: () => (stop(), editor.close()) };
}

/** @param {string} name @param {string} path @param {() => void} act */
function tool(name, path, act) {
  return h("button", { type: "button", class: "icon", "aria-label": name, title: name, onclick: act }, icon(path));
}

/** @param {Editor} editor */
function regions(editor) {
  const boxes = KEYS.map((key) => {
    const box = h("input", { type: "checkbox", checked: true, onchange: () => (box.checked ? editor.visible.add(key) : editor.visible.delete(key), editor.render()) });
    const swatch = h("span", { class: "swatch" });
    swatch.style.background = COLOURS.get(key) ?? "";
    return h("label", { class: "check" }, box, swatch, key);
  });
  const lines = h("input", { type: "checkbox", checked: true, onchange: () => ((editor.regions = lines.checked), editor.render()) });
  return h("section", { "aria-labelledby": "regions" }, h("h2", { id: "regions" }, "Shown"), h("div", { class: "row" }, boxes), h("label", { class: "check" }, lines, "Regions"));
}

/** @param {Editor} editor @param {() => Point[]} present @param {any} refinement @param {(points: Point[]) => void} take */
function correction(editor, present, refinement, take) {
  const after = refinement.report?.points_px;
  const name = ABOUT.get(refinement.name) ?? refinement.label;
  const said = h("span", { class: "small quiet number", title: "mean move, of the distance of the eyes" });
  const button = h("button", { type: "button", class: "pick" }, h("span", { class: "grow" }, h("b", {}, name)), said);
  const tell = () => {
    said.textContent = after?.length === COUNT && present().length === COUNT ? `${meanShift(present(), after).toFixed(1)} %` : "";
    button.disabled = !said.textContent;
  };
  const compare = (/** @type {boolean} */ on) => ((editor.ghost = on ? after : null), editor.render());
  for (const on of ["pointerenter", "focus"]) button.addEventListener(on, () => compare(true));
  for (const off of ["pointerleave", "blur"]) button.addEventListener(off, () => compare(false));
  button.addEventListener("click", () => (compare(false), take(after)));
  return { view: h("li", {}, button), tell };
}

function help() {
  const rows = [[", .", "the landmark before, the next"], ["← ↑ ↓ →", "move it, with Shift by ten"], ["Ctrl Z", "undo, with Shift redo"], ["+ − 0", "larger, smaller, whole face"]];
  return h("section", { id: "editor-help", "aria-label": "Keys" }, h("div", { class: "small quiet stack tight" }, rows.map(([key, what]) => h("p", {}, h("kbd", {}, key), ` ${what}`))));
}
