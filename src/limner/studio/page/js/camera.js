// The camera of this computer goes in; after a countdown a photo of what it sees comes out as JPEG.

import { h, icon, ICONS } from "./dom.js";

const WANTED = { video: { facingMode: "user", width: { ideal: 1280 }, height: { ideal: 960 } }, audio: false };
const QUALITY = 0.94;

/** What can go wrong, and what to do about it. */
const TROUBLES = new Map([
  ["NotAllowedError", "The browser may not use the camera. Allow it beside the address, or choose a photo."],
  ["NotFoundError", "No camera was found. Plug one in, or choose a photo."],
  ["NotReadableError", "Another program is using the camera. Close it, or choose a photo."],
]);

/** @param {unknown} error */
export function cameraTrouble(error) {
  const name = error instanceof Error ? error.name : "";
  return TROUBLES.get(name) ?? "The camera cannot be used here. Choose a photo instead.";
}

/** A running camera in a video element. */
export class Camera {
  constructor() {
    this.video = h("video", { playsinline: true, autoplay: true, muted: true, "aria-label": "What the camera sees" });
    this.video.muted = true;
    /** @type {MediaStream | null} */
    this.stream = null;
  }

  /** Asks for the camera and waits for its first picture. */
  async start() {
    if (!navigator.mediaDevices) throw new Error("no camera outside localhost and https");
    this.stream = await navigator.mediaDevices.getUserMedia(WANTED);
    this.video.srcObject = this.stream;
    await this.video.play();
  }

  /** @returns {Promise<Blob>} what it sees now, not mirrored */
  async photo() {
    const canvas = h("canvas");
    canvas.width = this.video.videoWidth;
    canvas.height = this.video.videoHeight;
    canvas.getContext("2d").drawImage(this.video, 0, 0);
    return new Promise((done, fail) => {
      canvas.toBlob((/** @type {Blob | null} */ blob) => (blob ? done(blob) : fail(new Error("no picture"))), "image/jpeg", QUALITY);
    });
  }

  stop() {
    this.stream?.getTracks().forEach((track) => track.stop());
    this.stream = null;
  }
}

/**
 * Counts down in an element, one number a second.
 * @param {HTMLElement} place
 * @param {number} from
 * @param {AbortSignal} signal
 * @param {number} [second] [ms]
 * @returns {Promise<boolean>} whether it came to its end
 */
export async function countdown(place, from, signal, second = 1000) {
  const number = h("div", { class: "count", role: "status" });
  place.append(number);
  for (let left = from; left > 0 && !signal.aborted; left -= 1) {
    number.textContent = String(left);
    await new Promise((done) => setTimeout(done, second));
  }
  number.remove();
  return !signal.aborted;
}

/**
 * The camera on the easel: see yourself, count down, look at the photo, keep it or take another.
 * @param {{keep: (photo: Blob) => void, leave: () => void, fail: (text: string) => void, seconds?: number}} how
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function cameraView({ keep, leave, fail, seconds = 3 }) {
  const camera = new Camera();
  const stop = new AbortController();
  const bar = h("div", { class: "camera-bar" });
  const paper = h("div", { class: "paper wide mirror" }, camera.video, bar);

  const ready = () => {
    paper.querySelector("img")?.remove();
    camera.video.hidden = false;
    bar.replaceChildren(
      h("button", { type: "button", class: "primary", onclick: take }, icon(ICONS.camera), "Take the photo"),
      h("button", { type: "button", onclick: leave }, "Back"),
    );
    bar.querySelector("button")?.focus();
  };
  const take = async () => {
    bar.replaceChildren();
    if (await countdown(paper, seconds, stop.signal)) review(await camera.photo());
  };
  const review = (/** @type {Blob} */ photo) => {
    const still = h("img", { alt: "The photo just taken", src: URL.createObjectURL(photo) });
    camera.video.hidden = true;
    paper.prepend(still);
    bar.replaceChildren(
      h("button", { type: "button", class: "primary", onclick: () => keep(photo) }, "Use this photo"),
      h("button", { type: "button", onclick: ready }, icon(ICONS.again), "Take another"),
    );
    bar.querySelector("button")?.focus();
  };
  camera.start().then(() => (stop.signal.aborted ? camera.stop() : ready()), (error) => fail(cameraTrouble(error)));
  return { element: paper, close: () => (stop.abort(), camera.stop()) };
}
