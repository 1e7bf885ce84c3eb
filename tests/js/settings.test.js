// Settings: a tree that loses none, values checked as the server checks them, sliders that go and come back.
import assert from "node:assert/strict";
import test from "node:test";
import { changed, find, fromShare, parse, toShare, tree, words } from "../../src/limner/studio/page/js/settings.js";
import { placeOf, settingsAt, wordsAt } from "../../src/limner/studio/page/js/sliders.js";

const about = (path, more = {}) => ({ path, type: "float", default: 1, low: null, high: null, unit: "", choices: [], help: `about ${path}`, ...more });
const all = ["style", "page.size", "page.margin_mm", "arm.place.at", "arm.retime.margin", "arm.x"].map((path) => about(path));

test("the tree holds every setting once", () => {
  const seen = [];
  const walk = (group) => {
    seen.push(...group.settings.map(({ path }) => path));
    group.groups.forEach(walk);
  };
  walk(tree(all));
  assert.deepEqual(seen.sort(), all.map(({ path }) => path).sort());
});

test("texts are read as the setting's kind, within its limits", () => {
  assert.deepEqual(parse(about("a"), " 2.5 "), { value: 2.5 });
  assert.deepEqual(parse(about("a"), ""), {});
  assert.deepEqual(parse(about("a", { type: "float?" }), "auto"), { value: null });
  assert.deepEqual(parse(about("a", { type: "text" }), " as it is "), { value: " as it is " });
  assert.ok(parse(about("a"), "many").error);
  assert.ok(parse(about("a", { type: "int" }), "2.5").error);
  assert.ok(parse(about("a", { low: 1 }), "0.5").error);
  assert.ok(parse(about("a", { high: 1 }), "1.5").error);
});

test("a value that is the default is taken back", () => {
  assert.deepEqual(changed({ a: 1, b: 2 }, "b", 5, 5), { a: 1 });
  assert.deepEqual(changed({ a: 1 }, "b", 5, 6), { a: 1, b: 5 });
  assert.deepEqual(changed({ a: 1 }, "a", undefined), {});
});

test("search wants all words, in path or help", () => {
  assert.deepEqual(find(all, "MARGIN page").map(({ path }) => path), ["page.margin_mm"]);
  assert.equal(find(all, "").length, all.length);
});

test("units go from names", () => assert.deepEqual(["hair_apart", "margin_mm", "mm"].map(words), ["hair apart", "margin", "mm"]));

test("shares of a range go and come back, wide ranges by factors", () => {
  for (const [low, high] of [[0, 1], [-3, 8], [0.25, 30], [60, 12000]]) {
    for (const share of [0, 0.1, 0.5, 1]) assert.ok(Math.abs(toShare(fromShare(share, low, high), low, high) - share) < 1e-9);
  }
  assert.ok(Math.abs(fromShare(0.5, 1, 100) - 10) < 1e-9);
});

const slider = { name: "detail", label: "Detail", help: "", default: 0.5, sets: [{ path: "a", stops: [[0, 0.4], [0.5, 1], [1, 2.5]] }, { path: "b", stops: [[0, 4], [0.5, 2.5], [1, 1]] }] };
const stepped = { name: "tone", label: "Tone", help: "", default: 0, sets: [{ path: "t", steps: ["none", "light", "medium", "rich"] }] };

test("a slider's settings tell its place again", () => {
  for (let place = 0; place <= 1; place += 0.05) assert.ok(Math.abs(placeOf(slider, settingsAt(slider, place)) - place) < 1e-4);
  for (const i of [0, 1, 2, 3]) assert.equal(placeOf(stepped, settingsAt(stepped, i / 3)), i / 3);
  assert.deepEqual(settingsAt(slider, 0.25), { a: 0.7, b: 3.25 });
  assert.equal(placeOf(slider, {}), 0.5);
});

test("values beyond a slider's stops stand at its ends", () => {
  assert.equal(placeOf(slider, { a: 0.1 }), 0);
  assert.equal(placeOf(slider, { a: 9 }), 1);
});

test("a slider says where it stands", () => {
  assert.deepEqual([0.2, 0.5, 0.9].map((place) => wordsAt(slider, place)), ["less", "as usual", "more"]);
  assert.equal(wordsAt(stepped, 1), "rich");
});
