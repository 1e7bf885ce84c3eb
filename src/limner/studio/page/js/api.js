// Requests to the server go out; what it answers, or an error in its own words, comes back.

/** What the server refused, in one line. */
export class Refused extends Error {
  /** @param {string} message @param {number} status */
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

/**
 * @param {string} path
 * @param {RequestInit} [how]
 * @returns {Promise<any>}
 */
export async function ask(path, how = {}) {
  let answer;
  try {
    answer = await fetch(path, { credentials: "same-origin", ...how });
  } catch {
    throw new Refused("limner does not answer. Is it still running in its terminal?", 0);
  }
  const body = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new Refused(body.error ?? `limner answered ${answer.status}`, answer.status);
  return body;
}

/** Whether there is something at an address. @param {string} path */
export function answers(path) {
  return fetch(path, { credentials: "same-origin" }).then(({ ok }) => ok, () => false);
}

/**
 * Fetches a file, and has the browser save it; an error is told in the server's words instead of saved.
 * @param {string} path
 * @param {string} name
 */
export async function download(path, name) {
  const answer = await fetch(path, { credentials: "same-origin" });
  if (!answer.ok) throw new Refused((await answer.json().catch(() => ({}))).error ?? `limner answered ${answer.status}`, answer.status);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/**
 * @param {string} path
 * @param {any} value
 */
export function tell(path, value) {
  return ask(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(value) });
}

/** Where the page finds a photo. @param {{photo: string}} about */
export function photoUrl({ photo }) {
  return `api/photo/${photo}.jpg`;
}

/**
 * @param {Blob} photo
 */
export function sendPhoto(photo) {
  return ask("api/photo", { method: "POST", headers: { "content-type": "application/octet-stream" }, body: photo });
}
