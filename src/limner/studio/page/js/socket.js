// Wishes go out over one WebSocket, at most one a frame and the latest wins; messages come back, each with its frame.

import { decode } from "./frames.js";

/** @typedef {import("./frames.js").Frame} Frame */
/** @typedef {Record<string, any>} Message */

/** A connection that comes back by itself. */
export class Connection {
  /**
   * @param {string} path
   * @param {{message: (message: Message, frame: Frame | null) => void, state: (open: boolean) => void}} tell
   */
  constructor(path, tell) {
    this.url = new URL(path, location.href);
    this.url.protocol = this.url.protocol.replace("http", "ws");
    this.tell = tell;
    this.rev = 0;
    /** @type {Message | null} */
    this.wish = null;
    /** @type {Message | null} */
    this.waiting = null;
    this.wait = 300;
    this.open();
  }

  open() {
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this._opened();
    this.socket.onmessage = ({ data }) => this._received(data);
    this.socket.onclose = () => this._closed();
  }

  /**
   * Sends a wish with the next frame of the screen; an older one that was not sent is forgotten.
   * @param {Message} wish
   * @returns {number} its rev
   */
  send(wish) {
    this.rev += 1;
    const scheduled = this.wish !== null;
    this.wish = { ...wish, rev: this.rev };
    if (!scheduled) requestAnimationFrame(() => this._flush());
    return this.rev;
  }

  _flush() {
    if (!this.wish || this.socket?.readyState !== WebSocket.OPEN) return;
    this.socket.send(JSON.stringify(this.wish));
    this.wish = null;
  }

  _opened() {
    this.wait = 300;
    this.tell.state(true);
    this._flush();
  }

  /** @param {string | ArrayBuffer} data */
  _received(data) {
    if (typeof data !== "string") {
      const message = this.waiting;
      this.waiting = null;
      if (message) this.tell.message(message, decode(data));
      return;
    }
    const message = JSON.parse(data);
    if (message.frame) this.waiting = message;
    else this.tell.message(message, null);
  }

  _closed() {
    this.waiting = null;
    this.tell.state(false);
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(this.wait * 1.7, 5000);
  }
}
