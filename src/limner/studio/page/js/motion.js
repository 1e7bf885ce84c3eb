// What the person asked of their system about moving pictures.

/** Whether movement is unwelcome. */
export function calm() {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
