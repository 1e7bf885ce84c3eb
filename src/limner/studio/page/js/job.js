// A job of the machine goes in; what it does, in words, and what one may do now, come out.

/** @typedef {{state: string, share?: number, stroke?: number, strokes?: number, elapsed_s?: number, left_s?: number, error?: string, target?: string}} Job */

const WORDS = new Map([
  ["idle", "ready"], ["framing", "tracing the frame"], ["running", "drawing"], ["pausing", "pausing"], ["paused", "paused"], ["cancelling", "stopping"],
  ["cancelled", "stopped"], ["done", "done"], ["error", "failed"], ["lost", "connection lost"], ["connecting", "connecting"],
]);
const BUSY = new Set(["connecting", "framing", "running", "pausing", "paused", "cancelling", "lost"]);
const MAY = new Map([
  ["running", ["pause", "cancel"]], ["pausing", ["cancel"]], ["paused", ["resume", "cancel"]], ["framing", ["cancel"]], ["lost", ["resume", "cancel"]], ["connecting", ["cancel"]],
]);

/** @param {Job} job */
export function stateWords(job) {
  return WORDS.get(job.state) ?? job.state;
}

/** Whether the machine has work. @param {Job | null} job */
export function busy(job) {
  return Boolean(job && BUSY.has(job.state));
}

/** @param {Job} job @param {"pause" | "resume" | "cancel"} action */
export function may(job, action) {
  return MAY.get(job.state)?.includes(action) ?? false;
}
