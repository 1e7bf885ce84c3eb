// Photos dropped on the page or pasted into it go to the app.

/** @param {import("./app.js").App} app */
export function takeDrops(app) {
  const { body } = document;
  let depth = 0;
  const over = (/** @type {number} */ change) => {
    depth = Math.max(0, depth + change);
    body.classList.toggle("dropping", depth > 0);
    body.dataset.drop = "Drop the photo";
  };
  addEventListener("dragenter", (event) => (event.preventDefault(), over(1)));
  addEventListener("dragleave", () => over(-1));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    over(-depth);
    take(app, event.dataTransfer);
  });
  addEventListener("paste", (event) => take(app, event.clipboardData));
}

/** @param {import("./app.js").App} app @param {DataTransfer | null} data */
function take(app, data) {
  const file = data?.files[0];
  if (file) app.upload(file);
}
