// A report goes in; what the drawing costs, in a row of figures, comes out.

import { h } from "../dom.js";
import { count, duration, length, percent } from "../format.js";

/** @param {any} report */
export function figures(report) {
  const rows = report
    ? [
        ["Time", duration(report.seconds)], ["Strokes", count(report.strokes)], ["Points", count(report.points)],
        ["Ink", length(report.ink_mm)], ["Travel", length(report.travel_mm)], ["Lifts", count(report.lifts)], ["Likeness", percent(report.likeness)],
      ]
    : [];
  return h("dl", { class: "figures" }, rows.map(([name, value]) => h("div", {}, h("dt", {}, name), h("dd", {}, value))));
}
