// Versions of a thing go in; the present one, undo and redo come out.

/** @template T */
export class History {
  /**
   * @param {T} first
   * @param {number} [limit] versions that are kept
   */
  constructor(first, limit = 200) {
    this.limit = limit;
    /** @type {T[]} */
    this.versions = [first];
    this.at = 0;
  }

  /** @returns {T} */
  get present() {
    return this.versions[this.at];
  }

  /** @returns {T} */
  get first() {
    return this.versions[0];
  }

  get canUndo() {
    return this.at > 0;
  }

  get canRedo() {
    return this.at < this.versions.length - 1;
  }

  /**
   * A new version; what had been undone is gone. The first version is never forgotten: reset goes back to it.
   * @param {T} version
   */
  push(version) {
    this.versions.splice(this.at + 1);
    this.versions.push(version);
    if (this.versions.length > this.limit) this.versions.splice(1, 1);
    this.at = this.versions.length - 1;
  }

  undo() {
    if (this.canUndo) this.at -= 1;
    return this.present;
  }

  redo() {
    if (this.canRedo) this.at += 1;
    return this.present;
  }
}
