// The page that `curv view` serves: the same as that of `curv report`, and what it does when the file changes.
import assert from "node:assert/strict";
import { once } from "node:events";
import { renameSync, rmSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { Browser, findBrowser } from "./browser.mjs";
import {
  askFor, choose, clickOn, expectValue, inFolder, pictureOf, pointTable, READY, readCsv, readNumber, removeFolder, runCurv,
  view,
} from "./helpers.mjs";
import { countHoles, shareChanged } from "./picture.mjs";

let browser, tab;
const running = [];

/** Starts `curv view`, which ends with the tests if not before. */
async function start(...words) {
  const started = await view(...words);
  running.push(started.child);
  return started;
}

const generation = (number) => `document.documentElement.dataset.generation === "${number}" && ` +
  "document.documentElement.dataset.drawn === 'smooth'";

before(async () => {
  browser = await Browser.start(findBrowser());
  runCurv("generate", "ellipsoid", "--points=3000", "-o", inFolder("cloud.ply"));
  runCurv("estimate", inFolder("cloud.ply"), "-o", inFolder("result.csv"), "--k=30");
  tab = await browser.openTab(800, 600);
});

after(async () => {
  for (const child of running) child.kill("SIGKILL");
  await browser?.close();
  removeFolder();
});

test("is served to a browser of this machine, points beside the page", async () => {
  const { child, address } = await start("result.csv");
  await tab.open(address, READY);
  assert.equal(await tab.evaluate("document.getElementById('title').textContent"), "result.csv");
  const rows = readCsv("result.csv");
  for (const index of [0, 1234, 2999]) {
    await askFor(tab, index);
    const told = await pointTable(tab);
    assert.equal(readNumber(told.Index.replaceAll(",", "")), index);
    expectValue(told["Mean curvature H"], rows[index].mean_curvature, `H of point ${index}`);
    const position = told.Position.split(", ").map(readNumber);
    for (const [axis, name] of ["x", "y", "z"].entries()) {
      assert.ok(Math.abs(position[axis] - rows[index][name]) < 2e-4, `${name} of point ${index}`);
    }
  }
  assert.deepEqual(tab.errors, []);
  assert.deepEqual(tab.requests.filter((url) => !url.startsWith("data:")),
                   [address, `${address}/report`, `${address}/points/1`]);
  child.kill("SIGINT");
  const [code] = await once(child, "exit");
  assert.equal(code, 0);
});

test("looks like the page of curv report", async () => {
  runCurv("report", inFolder("result.csv"), "-o", inFolder("report.html"));
  const { address } = await start("result.csv");
  await tab.open(address, READY);
  const served = await pictureOf(tab);
  await tab.open(inFolder("report.html"), READY);
  // Splats are added up in another order, and their sums rounded.
  assert.ok(shareChanged(served, await pictureOf(tab)) < 0.002);
});

test("waits for a file that is not there, and follows it from then on", async () => {
  const { address } = await start("later.csv", "--watch");
  await tab.open(address, "document.getElementById('progress').textContent === 'Waiting for later.csv …'");
  const write = (name, k) => {
    runCurv("estimate", inFolder("cloud.ply"), "-o", inFolder(name), `--k=${k}`);
    return readCsv(name);
  };
  write("later.csv", 30);
  await tab.waitFor(generation(1));

  // Somebody looks at something.
  await clickOn(tab, "#views button:nth-child(3)");
  await tab.evaluate("document.getElementById('canvas').focus()");
  for (const key of ["ArrowLeft", "+", "+"]) await tab.press(key, key.length === 1 ? key : undefined);
  await choose(tab, "quantity", "3");
  await tab.evaluate(`(() => {
    const input = document.getElementById("high");
    input.value = "7.5";
    input.dispatchEvent(new Event("change"));
  })()`);
  await askFor(tab, 77);
  await clickOn(tab, "#views button:nth-child(3)");
  const before = await pictureOf(tab);

  // Another estimate takes its place, of neighborhoods so large that it sees another curvature.
  const rows = write("later.csv", 1000);
  await tab.waitFor(generation(2));
  const told = await pointTable(tab);
  assert.equal(readNumber(told.Index), 77);
  expectValue(told["Principal curvature k₂"], rows[77].k2, "k2 of the new estimate");
  assert.equal(await tab.evaluate("document.getElementById('quantity').value"), "3");
  assert.equal(await tab.evaluate("document.getElementById('high').value"), "7.500");
  // The ellipsoid stands where it stood; its colors are others.
  const now = await pictureOf(tab);
  let moved = 0;
  const isPaper = (color) => color.every((c) => c > 250);
  for (let y = 0; y < now.height; y++) {
    for (let x = 0; x < now.width; x++) moved += isPaper(now.at(x, y)) === isPaper(before.at(x, y)) ? 0 : 1;
  }
  assert.equal(moved, 0);
  assert.ok(shareChanged(before, now) > 0.01);
  assert.deepEqual(tab.errors, []);
});

test("keeps what it shows while the file is gone or of no use", async () => {
  runCurv("estimate", inFolder("cloud.ply"), "-o", inFolder("kept.csv"), "--k=30");
  const { address } = await start("kept.csv", "--watch");
  await tab.open(address, generation(1));
  renameSync(inFolder("kept.csv"), inFolder("away.csv"));
  writeFileSync(inFolder("kept.csv"), "x,y,z\n1,2\n");
  // It has looked at the file once the next one is shown: looks are one after the other.
  rmSync(inFolder("kept.csv"));
  runCurv("select", inFolder("away.csv"), "--where", "z > 0", "-o", inFolder("kept.csv"));
  await tab.waitFor(generation(2));
  const half = readCsv("kept.csv").length;
  assert.ok(half > 1000 && half < 2000);
  assert.equal(await tab.evaluate("document.getElementById('subtitle').textContent"),
               `${half.toLocaleString("en-US")} points`);
  assert.equal(await tab.evaluate("document.documentElement.dataset.failed"), undefined);
});

test("says that nothing more comes once curv view has ended", async () => {
  const { child, address } = await start("result.csv", "--watch");
  await tab.open(address, generation(1));
  child.kill("SIGINT");
  await once(child, "exit");
  await tab.waitFor("document.getElementById('progress').textContent.startsWith('Nothing more comes from curv view')");
});

test("draws points as they come, and has them all in the end", async () => {
  // Above a million points come in blocks: a wavy sheet of 1,100 x 1,000 points.
  const [columns, rows] = [1100, 1000];
  const scalars = new Float32Array(3 * columns * rows);
  for (let i = 0; i < columns * rows; i++) {
    const [x, y] = [i % columns, Math.floor(i / columns)];
    scalars.set([x, y, 30 * Math.sin(x / 100)], 3 * i);
  }
  const head = ["ply", "format binary_little_endian 1.0", `element vertex ${columns * rows}`,
    ...["x", "y", "z"].map((name) => `property float ${name}`), "end_header", ""].join("\n");
  writeFileSync(inFolder("large.ply"), Buffer.concat([Buffer.from(head), Buffer.from(scalars.buffer)]));
  const { address } = await start("large.ply", "--up=z");
  // Without a graphics card a busy machine takes its time to draw so many.
  await tab.open(address, READY, 150);
  assert.equal(await tab.evaluate("document.getElementById('subtitle').textContent"), "1,100,000 points");
  for (const index of [0, 650_001, 1_099_999]) {
    await askFor(tab, index);
    const told = await pointTable(tab);
    assert.equal(readNumber(told.Index.replaceAll(",", "")), index);
    assert.ok(Math.abs(readNumber(told.Position.split(", ")[0]) - (index % columns)) < 0.02, told.Position);
  }
  const { picture, ready } = await tab.evaluate("({ ...document.documentElement.dataset })");
  assert.ok(Number(picture) < Number(ready));
  // Seen from above, the sheet is a rectangle without holes.
  await clickOn(tab, "#views button:nth-child(6)");
  assert.equal(countHoles(await pictureOf(tab), [255, 255, 255]).holes, 0);

  // A file has room for a million of them, and says so.
  assert.match(runCurv("report", inFolder("large.ply"), "-o", inFolder("large.html")),
               /large.html: 1,000,000 of 1,100,000 points of/);
  await tab.open(inFolder("large.html"), "document.querySelector('#summary table')");
  assert.equal(await tab.evaluate("document.getElementById('subtitle').textContent"),
               "1,100,000 points, of which 1,000,000 are shown");
});
