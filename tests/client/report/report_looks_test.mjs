// The page of `curv report` in narrow windows and dark rooms, and with files that mean harm or are large.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { Browser, findBrowser } from "./browser.mjs";
import {
  askFor, expectQuiet, expectValue, inFolder, LOWEST_CONTRAST, pictureOf, pointTable, READY, readCsv, readNumber,
  removeFolder, runCurv, writeReport,
} from "./helpers.mjs";

let browser, tab, path;

before(async () => {
  browser = await Browser.start(findBrowser());
  runCurv("generate", "torus", "--points=3000", "-o", inFolder("cloud.ply"));
  runCurv("estimate", inFolder("cloud.ply"), "-o", inFolder("result.csv"), "--k=30");
  path = writeReport("result.csv", "report.html");
  tab = await browser.openTab(400, 800);
});

after(async () => {
  await browser?.close();
  removeFolder();
});

test("fits into a window of 400 pixels", async () => {
  await tab.open(path, READY);
  assert.ok(await tab.evaluate("document.documentElement.scrollWidth") <= 400);
  const outside = await tab.evaluate(`[...document.querySelectorAll("select, input, button")].filter((element) => {
    const { left, right } = element.getBoundingClientRect();
    return left < 0 || right > innerWidth + 0.5;
  }).map((element) => element.outerHTML)`);
  assert.deepEqual(outside, []);
  const picture = await pictureOf(tab);
  assert.ok(picture.width === 400 && picture.height >= 300);
  expectQuiet(tab, path);
});

test("is readable in both schemes", async () => {
  const papers = [];
  for (const scheme of ["light", "dark"]) {
    await tab.setScheme(scheme);
    await askFor(tab, 5);
    const [contrast, text] = await tab.evaluate(LOWEST_CONTRAST);
    assert.ok(contrast >= 4.5, `${scheme}: contrast ${contrast.toFixed(2)} of "${text}"`);
    papers.push((await pictureOf(tab)).at(1, 1));
  }
  assert.ok(papers[0].every((c) => c > 240) && papers[1].every((c) => c < 40), JSON.stringify(papers));
  await tab.setScheme("light");
});

test("shows names of a hostile file as text", async () => {
  const names = ["</script><script>window.harm=1</script>", "<img/src=x/onerror=window.harm=2>", "]]>&lt;",
    "@curv-points@"];
  const lines = Array.from({ length: 50 }, (_, i) => [Math.cos(i), Math.sin(i), i / 50, 1, 2, 3, 4].join(" "));
  const file = "<img src=x onerror=window.harm=3>.ply";
  const head = ["ply", "format ascii 1.0", "comment <script>window.harm=4</script>", "element vertex 50",
    ...["x", "y", "z", ...names].map((name) => `property float ${name}`), "end_header"];
  writeFileSync(inFolder(file), [...head, ...lines, ""].join("\n"));
  const hostile = writeReport(file, "hostile.html", "--unit=</script><b>m");
  const other = await browser.openTab(800, 600);
  await other.open(hostile, READY);
  assert.equal(await other.evaluate("window.harm"), undefined);
  assert.equal(await other.evaluate("document.getElementById('title').textContent"), file);
  const shown = await other.evaluate("[...document.getElementById('quantity').options].map((o) => o.textContent)");
  assert.deepEqual(shown, names);
  assert.equal(await other.evaluate("document.querySelectorAll('img').length"), 0);
  expectQuiet(other, hostile);
});

test("says that it is thinned, and keeps the file's indices", async () => {
  const rows = readCsv("result.csv");
  const thinned = writeReport("result.csv", "thinned.html", "--points=500");
  const other = await browser.openTab(800, 600);
  await other.open(thinned, READY);
  const text = await other.evaluate("document.body.innerText");
  assert.match(text, /3,000 points, of which 500 are shown/);
  assert.match(text, /The page shows 500 of them, chosen by a hash of their index/);
  let held = 0;
  for (let index = 0; index < 60; index++) {
    await askFor(other, index);
    const told = await pointTable(other);
    if (!told.Index) continue;
    held += 1;
    assert.equal(readNumber(told.Index), index);
    expectValue(told["Mean curvature H"], rows[index].mean_curvature, `H of point ${index}`);
  }
  // 10 are expected of 60; fewer than 2 or more than 25 would be no even choice.
  assert.ok(held >= 2 && held <= 25, `${held} of 60 points are held`);
});

test("counts points that are nowhere, and does not draw them", async () => {
  const weight = (i) => (i === 7 ? "nan" : 1);
  const lines = Array.from({ length: 200 }, (_, i) => [Math.cos(i), Math.sin(i), i / 200, weight(i)].join(" "));
  lines[3] = "nan 0 0 1";
  writeFileSync(inFolder("nowhere.ply"), ["ply", "format ascii 1.0", "element vertex 200",
    ...["x", "y", "z", "weight"].map((name) => `property float ${name}`), "end_header", ...lines, ""].join("\n"));
  const page = writeReport("nowhere.ply", "nowhere.html");
  const other = await browser.openTab(800, 600);
  await other.open(page, READY);
  assert.match(await other.evaluate("document.body.innerText"), /1 point has no finite position/);
  await askFor(other, 3);
  assert.equal((await pointTable(other)).Position, "not finite");
  await askFor(other, 7);
  assert.equal((await pointTable(other)).weight, "none");
  expectQuiet(other, page);
});
