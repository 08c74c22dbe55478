// The page of `curv report` as its reader meets it, in a Chromium without a window.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { Browser, findBrowser } from "./browser.mjs";
import {
  askFor, choose, clickMarker, clickOn, expectQuiet, expectValue, inFolder, pictureOf, pointTable, READY, readCsv, readNumber,
  removeFolder, runCurv, writeReport,
} from "./helpers.mjs";
import { countHoles, shareChanged } from "./picture.mjs";

const POINTS = 4000;
let browser, tab, path, rows;

before(async () => {
  browser = await Browser.start(findBrowser());
  runCurv("generate", "ellipsoid", `--points=${POINTS}`, "-o", inFolder("cloud.ply"));
  // A radius within which some points have enough neighbors, and others not.
  runCurv("estimate", inFolder("cloud.ply"), "-o", inFolder("result.csv"), "--radius=0.12");
  rows = readCsv("result.csv");
  path = writeReport("result.csv", "report.html", "--unit=mm");
  tab = await browser.openTab(820, 600);
  await tab.open(path, READY);
});

after(async () => {
  await browser?.close();
  removeFolder();
});

/** The first point that holds, as the file tells it. */
const indexOf = (holds) => {
  const index = rows.findIndex(holds);
  assert.ok(index >= 0, "the cloud has no such point");
  return index;
};

test("draws a closed surface, and asks for nothing but its file", async () => {
  await clickOn(tab, "#views button");
  const picture = await pictureOf(tab);
  const { covered, holes } = countHoles(picture, [255, 255, 255]);
  assert.ok(covered > 0.2 * picture.width * picture.height, `${covered} pixels of the cloud`);
  assert.equal(holes, 0);
  // The count would see holes: splats of a quarter of the size leave some.
  const resize = (factor) => tab.evaluate(`(() => {
    const input = document.getElementById("splats");
    input.value = ${factor};
    input.dispatchEvent(new Event("input"));
  })()`);
  await resize(-2);
  assert.ok(countHoles(await pictureOf(tab), [255, 255, 255]).holes > 1000);
  await resize(0);
  expectQuiet(tab, path);
});

test("tells of a clicked point what the file says", async () => {
  const ok = indexOf((row) => row.status === "ok" && row.z > 0.5);
  await askFor(tab, ok);
  await pictureOf(tab);
  await tab.evaluate("document.getElementById('point').replaceChildren()");
  await clickMarker(tab);
  const told = await pointTable(tab);
  const row = rows[ok];
  assert.equal(readNumber(told.Index.replaceAll(",", "")), ok);
  assert.equal(told.Status, "ok");
  const position = told.Position.split(", ").map(readNumber);
  for (const [axis, name] of ["x", "y", "z"].entries()) assert.ok(Math.abs(position[axis] - row[name]) < 2e-4, name);
  expectValue(told["Mean curvature H"], row.mean_curvature, "H");
  expectValue(told["Gaussian curvature G"], row.gaussian_curvature, "G");
  expectValue(told["Principal curvature k₁"], row.k1, "k1");
  expectValue(told["Principal curvature k₂"], row.k2, "k2");
  expectValue(told["Radius of the neighborhood"], row.radius, "radius");
  assert.match(told["Mean curvature H"], / 1\/mm$/);
  assert.match(told["Gaussian curvature G"], / 1\/mm²$/);
});

test("shows both principal directions of a point", async () => {
  const ok = indexOf((row) => row.status === "ok" && row.k2 - row.k1 > 0.1);
  await askFor(tab, ok);
  const told = await pointTable(tab);
  for (const d of [1, 2]) {
    const direction = told[`Direction d${"₁₂"[d - 1]}`].split(", ").map(readNumber);
    const along = ["x", "y", "z"].reduce((sum, axis, i) => sum + direction[i] * rows[ok][`d${d}${axis}`], 0);
    // The page keeps them to 0.7 degrees, and shows two decimals.
    const angle = (180 / Math.PI) * Math.acos(Math.min(Math.abs(along) / Math.hypot(...direction), 1));
    assert.ok(angle < 1.2, `d${d} is ${angle} degrees off`);
  }
  const lengths = await tab.evaluate(`[1, 2].map((d) => document.getElementById("direction-" + d).getTotalLength())`);
  // The page turns the point to the viewer: both lines lie nearly in the picture, at their length of 84 pixels.
  for (const length of lengths) assert.ok(length > 80 && length < 84.1, `a line of ${length} pixels`);
});

test("has no curvature for a point whose status is not ok", async () => {
  const failed = indexOf((row) => row.status === "too_few_neighbors");
  await askFor(tab, failed);
  const told = await pointTable(tab);
  assert.equal(told.Status, "too_few_neighbors");
  for (const name of ["Mean curvature H", "Gaussian curvature G", "Principal curvature k₁"]) {
    assert.equal(told[name], "none");
  }
  assert.equal(told["Direction d₁"], undefined);
  const without = rows.filter((row) => row.status !== "ok").length;
  const text = await tab.evaluate("document.getElementById('coverage').textContent");
  assert.equal(text, `${without.toLocaleString("en-US")} points have no value, of 4,000: grey in the picture.`);
});

test("changes the picture with every entry of its menus", async () => {
  const [quantities, maps] = await tab.evaluate(`["quantity", "colormap"].map((id) =>
    [...document.getElementById(id).options].map((option) => option.value))`);
  assert.deepEqual(quantities.slice(-1), ["status"]);
  assert.ok(quantities.length >= 6 && maps.length >= 4);
  for (const [menu, entries] of [["quantity", quantities], ["colormap", maps]]) {
    if (menu === "colormap") await choose(tab, "quantity", "0");
    let last = null;
    for (const entry of entries) {
      await choose(tab, menu, entry);
      const picture = await pictureOf(tab);
      if (last) assert.ok(shareChanged(last, picture) > 0.01, `${menu} ${entry} changes nothing`);
      last = picture;
    }
  }
  await choose(tab, "colormap", maps[0]);
});

test("shows where the axes point, from every side", async () => {
  // Names stand beyond the tips of the axes: [right, up] of the middle that they start from.
  const names = () => tab.evaluate(`(() => {
    const axes = document.querySelector("#axes");
    const line = axes.querySelector("line");
    const [x, y] = ["x1", "y1"].map((name) => Number(line.getAttribute(name)));
    return Object.fromEntries([...axes.querySelectorAll("text")].map((text) =>
      [text.textContent, [Number(text.getAttribute("x")) - x, y + 5 - Number(text.getAttribute("y"))]]));
  })()`);
  // What is to the right and above, z being up; a minus: the other way.
  const expected = { Front: "+x +z", Back: "-x +z", Left: "-y +z", Right: "+y +z", Top: "+x +y", Bottom: "+x -y" };
  const buttons = await tab.evaluate("[...document.querySelectorAll('#views button')].map((b) => b.textContent)");
  assert.deepEqual(buttons, ["Three-quarter", ...Object.keys(expected)]);
  let last = await pictureOf(tab);
  for (const [at, name] of buttons.entries()) {
    await clickOn(tab, `#views button:nth-child(${at + 1})`);
    const picture = await pictureOf(tab);
    assert.ok(at === 0 || shareChanged(last, picture) > 0.01, `${name} changes nothing`);
    last = picture;
    const [right, up] = expected[name]?.split(" ") ?? [];
    if (!right) continue;
    const told = await names();
    const way = (sign) => (sign === "-" ? -1 : 1);
    assert.ok(way(right[0]) * told[right[1]][0] > 20, `${name}: ${right} is not to the right: ${JSON.stringify(told)}`);
    assert.ok(way(up[0]) * told[up[1]][1] > 20, `${name}: ${up} is not above: ${JSON.stringify(told)}`);
  }
  await clickOn(tab, "#views button");
});

test("leaves out the points of a status", async () => {
  await choose(tab, "quantity", "0");
  const all = await pictureOf(tab);
  await clickOn(tab, "#status-1");
  const failedOnly = await pictureOf(tab);
  await clickOn(tab, "#status-2");
  const none = await pictureOf(tab);
  const covered = (picture) => countHoles(picture, [255, 255, 255]).covered;
  assert.ok(covered(failedOnly) < 0.9 * covered(all));
  assert.equal(covered(none), 0);
  await clickOn(tab, "#status-1");
  await clickOn(tab, "#status-2");
  assert.equal(shareChanged(all, await pictureOf(tab)), 0);
});

test("is turned, zoomed and colored by keys", async () => {
  let last = await pictureOf(tab);
  for (const [id, keys] of [["canvas", ["ArrowLeft", "ArrowUp", "+", "0"]], ["high-handle", ["ArrowLeft"]]]) {
    await tab.evaluate(`document.getElementById("${id}").focus()`);
    for (const key of keys) {
      await tab.press(key, key.length === 1 ? key : undefined);
      const picture = await pictureOf(tab);
      assert.ok(shareChanged(last, picture) > 0.01, `${key} on ${id} changes nothing`);
      last = picture;
    }
  }
  await clickOn(tab, "#robust");
});

test("lets the key Tab reach everything", async () => {
  await tab.evaluate("document.activeElement.blur()");
  const reached = new Set();
  for (let i = 0; i < 40; i++) {
    await tab.press("Tab");
    reached.add(await tab.evaluate("document.activeElement.id"));
  }
  for (const id of ["canvas", "quantity", "colormap", "low-handle", "high-handle", "low", "high", "robust", "full",
    "splats", "index", "status-1", "status-2"]) assert.ok(reached.has(id), `Tab never comes to ${id}`);
});

test("takes a typed range, and refuses one that is none", async () => {
  const type = (id, text) => tab.evaluate(`(() => {
    const input = document.getElementById("${id}");
    input.value = "${text}";
    input.dispatchEvent(new Event("change"));
  })()`);
  const range = () => tab.evaluate("['low', 'high'].map((id) => document.getElementById(id).value)");
  await type("high", "0.5");
  await type("low", "-0,25");
  assert.deepEqual(await range(), ["−0.2500", "0.5000"]);
  await type("low", "7");
  await type("high", "much");
  assert.deepEqual(await range(), ["−0.2500", "0.5000"]);
  await clickOn(tab, "#robust");
});

test("sums the file up", async () => {
  const cells = await tab.evaluate(`[...document.querySelector("#summary tbody tr").cells].map((c) => c.textContent)`);
  const values = rows.map((row) => row.mean_curvature).filter(Number.isFinite).sort((a, b) => a - b);
  assert.equal(cells[0], "Mean curvature H (1/mm)");
  assert.equal(cells[1], values.length.toLocaleString("en-US"));
  expectValue(cells[2], values[0], "least");
  expectValue(cells[6], values[Math.round((values.length - 1) / 2)], "median");
  expectValue(cells[10], values.at(-1), "largest");
  const counts = await tab.evaluate("[...document.querySelectorAll('#statuses .count')].map((c) => c.textContent)");
  assert.equal(counts.reduce((sum, text) => sum + readNumber(text.replaceAll(",", "")), 0), POINTS);
});
