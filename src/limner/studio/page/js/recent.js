// The drawings that the server keeps go in; the latest of each face, with its lines and what it was drawn from, comes out.

import { ask, photoUrl } from "./api.js";
import { decode } from "./frames.js";
import { pageOf } from "./ink.js";

const MOST = 8;

/**
 * @param {any[]} known those that the page has already
 * @returns {Promise<any[]>} latest first
 */
export async function recentDrawings(known) {
  const { drawings } = await ask("api/drawings").catch(() => ({ drawings: [] }));
  const found = latest(drawings).slice(0, MOST).map((kept) => known.find(({ drawing }) => drawing === kept.drawing) ?? whole(kept));
  return (await Promise.all(found)).filter(Boolean);
}

/** Of each face of each photo the first, which is the latest. @param {any[]} drawings */
export function latest(drawings) {
  const keys = drawings.map(({ photo, wish }) => `${photo} ${wish.face}`);
  return drawings.filter((_, i) => keys.indexOf(keys[i]) === i);
}

/** @param {any} kept @returns {Promise<any>} null where its photo was let go of */
async function whole({ drawing, photo, wish, report }) {
  try {
    const found = await ask(`api/photo/${photo}`);
    const answer = await fetch(`api/drawing/${drawing}.lines`);
    if (!answer.ok) return null;
    const { lines } = decode(await answer.arrayBuffer());
    return { drawing, photo: { ...found, url: photoUrl(found) }, face: wish.face, points: wish.points_px, settings: wish.settings, lines, page: pageOf(report) };
  } catch {
    return null;
  }
}
