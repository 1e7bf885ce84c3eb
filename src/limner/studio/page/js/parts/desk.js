// What lies on the desk, but for the photo itself, goes into the tab's own memory; after a reload it lies there again.

import { answers } from "../api.js";

/** @typedef {import("../app.js").App} App */

const KEY = "limner-desk";

/** Notes every change. The tab forgets when it is closed, and the photo itself never leaves limner. @param {App} app */
export function remember(app) {
  app.store.watch(["photo", "face", "points", "settings", "robot"], ({ photo, face, points, settings, robot }) => {
    if (photo) sessionStorage.setItem(KEY, JSON.stringify({ photo, face, points, settings, robot }));
    else sessionStorage.removeItem(KEY);
  });
}

/** @param {App} app */
export async function restore(app) {
  const noted = sessionStorage.getItem(KEY);
  if (!noted) return;
  const desk = JSON.parse(noted);
  if (!(await answers(desk.photo.url))) return sessionStorage.removeItem(KEY);
  app.set(desk);
}
