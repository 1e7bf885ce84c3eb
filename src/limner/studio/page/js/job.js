// A job of the machine goes in; what it does, in words, comes out.

/** @typedef {{state: string, may: string[], drawing: string | null, target: string, name: string, strokes: number, stroke: number, share: number, seconds: number, elapsed_s: number, left_s: number, frame_only: boolean, error: string | null, said: string, next_pen: string, mine: boolean}} Job */

const WORDS = new Map([
  ["idle", "Ready"], ["connecting", "Connecting"], ["running", "Drawing"], ["pausing", "Pausing"], ["paused", "Paused"], ["cancelling", "Stopping"],
  ["cancelled", "Stopped"], ["done", "Done"], ["error", "Failed"], ["lost", "Connection lost"], ["interrupted", "Interrupted"],
]);
const BUSY = new Set(["connecting", "running", "pausing", "paused", "cancelling"]);
const HELP = new Map([
  ["pausing", "It pauses when the pen is lifted next."], ["paused", "The pen is up. It goes on where it was."], ["cancelling", "The pen is being raised."],
  ["cancelled", "The pen is up. It can go on where it was, or begin anew."], ["done", "Take the sheet off and sign it."],
  ["error", "Going on draws the stroke in doubt once more."], ["lost", "Look after the machine and its cable; then it can go on."],
  ["interrupted", "limner ended in the middle of it. It can go on at the right stroke."],
]);

/** @param {Job} job */
export function stateWords(job) {
  if (job.next_pen) return "Next pen";
  return job.state === "running" && job.frame_only ? "Going round the frame" : WORDS.get(job.state) ?? job.state;
}

/** Whether the machine has work. @param {Job | null} job */
export function busy(job) {
  return Boolean(job && BUSY.has(job.state));
}

/** Whether it has come to a halt that nobody wanted. @param {Job} job */
export function broken(job) {
  return ["error", "lost", "interrupted"].includes(job.state);
}

/** Whether there is a job at all: one that is done or was stopped is, until it is cleared. @param {Job | null} job */
export function there(job) {
  return Boolean(job && job.state !== "idle");
}

/** What the state means for the person. @param {Job} job */
export function helpWords(job) {
  if (job.next_pen) return `The pen is up. Put in the next one: ${job.next_pen}.`;
  return job.error ?? HELP.get(job.state) ?? job.said;
}
