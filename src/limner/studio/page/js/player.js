// A duration and a speed go in; the time that is shown, frame by frame, comes out.

/** Plays from 0 to a duration, like a film. */
export class Player {
  /** @param {(time: number) => void} show @param {(playing: boolean) => void} told */
  constructor(show, told) {
    this.show = show;
    this.told = told;
    this.time = 0;
    this.duration = 0;
    this.speed = 1;
    this.playing = false;
    /** Frames shown since playing began, and when it began [ms]: what the benchmark reads. */
    this.frames = 0;
    this.begun = 0;
    this.last = 0;
    this._step = this._step.bind(this);
  }

  play() {
    if (this.playing) return;
    if (this.time >= this.duration) this.time = 0;
    this.playing = true;
    this.frames = 0;
    this.begun = this.last = performance.now();
    this.told(true);
    requestAnimationFrame(this._step);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.told(false);
  }

  /** @param {number} time */
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    this.show(this.time);
  }

  /** @param {number} now [ms] */
  _step(now) {
    if (!this.playing) return;
    this.time = Math.min(this.time + (Math.max(0, now - this.last) / 1000) * this.speed, this.duration);
    this.last = now;
    this.frames += 1;
    this.show(this.time);
    if (this.time >= this.duration) this.pause();
    else requestAnimationFrame(this._step);
  }

  get framesPerSecond() {
    return this.frames / Math.max(1e-3, (this.last - this.begun) / 1000);
  }
}
