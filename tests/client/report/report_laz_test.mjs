// Reports of LAZ and COPC files, which the page decompresses: they tell what reports of the same points as plain LAS tell.
// The files are those of tests/client/io/las/pdal/, which PDAL and LASzip wrote.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { copyFileSync, readFileSync, renameSync, writeFileSync } from "node:fs";
import { after, before, beforeEach, test } from "node:test";
import { fileURLToPath } from "node:url";
import { inflateSync } from "node:zlib";
import { Browser, findBrowser } from "./browser.mjs";
import {
  askFor, clickMarker, expectQuiet, expectValue, inFolder, LOWEST_CONTRAST, pictureOf, pointTable, READY, readCsv, readNumber,
  removeFolder, runCurv, view, writeReport,
} from "./helpers.mjs";
import { shareChanged } from "./picture.mjs";

const fileOf = (name) => fileURLToPath(new URL(`../io/las/pdal/${name}`, import.meta.url));
const FAILED = "document.documentElement.dataset.failed";
let browser, tab, rows, decompresses;
const running = [];

before(async () => {
  browser = await Browser.start(findBrowser());
  for (const name of ["result_6.las", "result_6.laz", "result_1.laz", "terrain_3.las", "terrain_3.laz", "terrain_7.las",
    "terrain_7.laz", "terrain_7.copc.laz"]) copyFileSync(fileOf(name), inFolder(name));
  runCurv("select", inFolder("result_6.las"), "--where", "x == x", "-o", inFolder("result.csv"));
  rows = readCsv("result.csv");
  decompresses = /, which the page decompresses\n$/.test(runCurv("report", inFolder("result_6.laz"), "-o", inFolder("a.html")));
  tab = await browser.openTab(820, 600);
});

// A tab behind another draws nothing.
beforeEach(() => tab.send("Page.bringToFront"));

after(async () => {
  for (const child of running) child.kill("SIGKILL");
  await browser?.close();
  removeFolder();
});

/** A test of what only a curv does that has no codec of its own. */
const testOfCodec = (name, check) => test(name, (context) =>
  (decompresses ? check(context) : context.skip("this curv reads LAZ itself")));

/** The text of an element of a page's file. */
function partOf(path, id) {
  const page = readFileSync(path, "utf8");
  const begin = page.indexOf(`id="${id}">`) + `id="${id}">`.length;
  return page.slice(begin, page.indexOf("</script>", begin));
}

/** The report of a page of a plain file, and its arrays as they are unpacked. */
function unpack(path) {
  const { arrays, ...report } = JSON.parse(partOf(path, "report"));
  const bytes = inflateSync(Buffer.from(partOf(path, "points"), "base64"));
  const unpacked = {};
  let at = 0;
  for (const { name, count, bytes: width } of arrays) {
    unpacked[name] = Array.from({ length: count }, (_, i) => bytes[at + i] + (width === 2 ? 256 * bytes[at + count + i] : 0));
    at += count * width;
  }
  return { report, arrays: unpacked };
}

/** Has the codec of the page that is open make the report of another page's file. */
const makeInPage = (path) => tab.evaluate(`(async () => {
  const file = Uint8Array.from(atob(${JSON.stringify(partOf(path, "points"))}), (c) => c.charCodeAt(0));
  const { report, arrays } = await curvLaz.readLaz(${partOf(path, "report")}, file, () => {});
  return { report, arrays: Object.fromEntries(Object.entries(arrays).map(([name, values]) => [name, [...values]])) };
})()`);

testOfCodec("makes the same codes of compressed points as curv makes of plain ones", async () => {
  await tab.open(writeReport("result_6.laz", "report.html"), READY);
  const pairs = [["result_6.las", "result_6.laz"], ["terrain_3.las", "terrain_3.laz"], ["terrain_7.las", "terrain_7.laz"],
    ["terrain_7.las", "terrain_7.copc.laz"]];
  for (const [plain, compressed] of pairs) {
    for (const flags of [["--unit=m"], ["--points=100", "--up=y", "--quantity=nx"], ["--quantity=status"]]) {
      if (flags.at(-1) === "--quantity=status" && !plain.startsWith("result")) continue;
      const chosen = flags.filter((flag) => flag !== "--quantity=nx");
      const expected = unpack(writeReport(plain, "plain.html", ...chosen));
      const made = await makeInPage(writeReport(compressed, "compressed.html", ...chosen));
      made.report.title = plain;
      assert.deepEqual(made, expected, `${compressed} ${chosen}`);
    }
  }
});

test("tells of a clicked point what the file says", async () => {
  for (const name of ["result_6.laz", "result_1.laz"]) {
    tab.requests.length = 0;
    const path = writeReport(name, "report.html", "--unit=m");
    await tab.open(path, READY);
    const ok = rows.findIndex((row) => row.status === "ok" && row.z > 120.5);
    await askFor(tab, ok);
    await pictureOf(tab);
    await tab.evaluate("document.getElementById('point').replaceChildren()");
    await clickMarker(tab);
    const [told, row] = [await pointTable(tab), rows[ok]];
    assert.equal(readNumber(told.Index.replaceAll(",", "")), ok);
    assert.equal(told.Status, "ok");
    const position = told.Position.split(", ").map((text) => readNumber(text.replaceAll(",", "")));
    for (const [axis, at] of ["x", "y", "z"].entries()) assert.ok(Math.abs(position[axis] - row[at]) < 2e-4, `${name}: ${at}`);
    for (const [title, column] of [["Mean curvature H", "mean_curvature"], ["Gaussian curvature G", "gaussian_curvature"],
      ["Principal curvature k₁", "k1"], ["Principal curvature k₂", "k2"], ["Radius of the neighborhood", "radius"]]) {
      expectValue(told[title], row[column], `${name}: ${column}`);
    }
    for (const d of [1, 2]) {
      const direction = told[`Direction d${"₁₂"[d - 1]}`].split(", ").map(readNumber);
      const along = ["x", "y", "z"].reduce((sum, axis, i) => sum + direction[i] * row[`d${d}${axis}`], 0);
      assert.ok(Math.abs(along) / Math.hypot(...direction) > Math.cos((1.2 * Math.PI) / 180), `${name}: d${d}`);
    }
    await askFor(tab, rows.findIndex(({ status }) => status === "too_few_neighbors"));
    const failed = await pointTable(tab);
    assert.deepEqual([failed.Status, failed["Mean curvature H"]], ["too_few_neighbors", "none"]);
    expectQuiet(tab, path);
  }
});

test("says and shows what the page of the plain file does", async () => {
  const seen = [];
  for (const name of ["result_6.las", "result_6.laz"]) {
    await tab.open(writeReport(name, "report.html", "--points=700"), READY);
    assert.equal(await tab.evaluate("document.getElementById('title').textContent"), name);
    const text = await tab.evaluate("['subtitle', 'panel'].map((id) => document.getElementById(id).innerText)");
    seen.push({ text, picture: await pictureOf(tab) });
  }
  assert.deepEqual(seen[1].text, seen[0].text);
  assert.equal(seen[1].text[0], "900 points, of which 700 are shown");
  assert.ok(shareChanged(seen[0].picture, seen[1].picture) < 0.002);
});

test("shows a COPC file without results by its own columns", async () => {
  await tab.open(writeReport("terrain_7.copc.laz", "copc.html"), READY);
  const shown = await tab.evaluate("[...document.getElementById('quantity').options].map((option) => option.textContent)");
  assert.equal(shown[0], "intensity");
  assert.match(await tab.evaluate("document.body.innerText"), /The file has no column of statuses/);
});

test("fits into a window of 400 pixels, and into a dark room", async () => {
  const narrow = await browser.openTab(400, 800);
  await narrow.setScheme("dark");
  await narrow.open(writeReport("result_6.laz", "narrow.html"), READY);
  assert.ok(await narrow.evaluate("document.documentElement.scrollWidth") <= 400);
  const picture = await pictureOf(narrow);
  assert.ok(picture.width === 400 && picture.at(1, 1).every((c) => c < 40));
  const [contrast, text] = await narrow.evaluate(LOWEST_CONTRAST);
  assert.ok(contrast >= 4.5, `contrast ${contrast.toFixed(2)} of "${text}"`);
});

testOfCodec("carries a codec where it needs one, and allows no other code", async () => {
  const [plain, compressed] = ["result_6.las", "result_6.laz"].map((name) => readFileSync(writeReport(name, "p.html"), "utf8"));
  const policyOf = (page) => page.match(/Content-Security-Policy" content="([^"]*)"/)[1];
  const script = String.raw`'sha256-[\w+/]+='`;
  assert.match(policyOf(plain), new RegExp(`^default-src 'none'; script-src ${script}; style-src 'unsafe-inline'; img-src data:$`));
  assert.match(policyOf(compressed), new RegExp(
    `^default-src 'none'; script-src ${script} ${script} 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data:$`));
  assert.ok(!plain.includes("laz-perf"));
  assert.match(compressed, /laz-perf \S+ is part of this page\.\s+Apache License\s+Version 2\.0/);
  const other = await browser.openTab(820, 600);
  await other.open(inFolder("p.html"), READY);
  const { exceptionDetails } = await other.send("Runtime.evaluate",
                                                { expression: "new Function('return 1')()", allowUnsafeEvalBlockedByCSP: false });
  assert.match(exceptionDetails?.exception.description ?? "it runs", /^EvalError/);
});

/** Opens the report of bytes that are no good; returns what the page says. */
async function openBroken(bytes, name = "broken.laz") {
  writeFileSync(inFolder(name), bytes);
  await tab.open(writeReport(name, "broken.html"), FAILED);
  const said = await tab.evaluate("document.getElementById('progress').textContent");
  assert.equal(await tab.evaluate("document.documentElement.dataset.ready"), undefined);
  assert.equal(await tab.evaluate("document.getElementById('quantity').checkVisibility({ visibilityProperty: true })"), false);
  assert.equal(await tab.evaluate("document.querySelectorAll('#summary td, #point td, #quantity option').length"), 0);
  return said;
}

const changed = (name, change) => {
  const bytes = readFileSync(fileOf(name));
  change(bytes, bytes.readUInt32LE(96));
  return bytes;
};

testOfCodec("says what is wrong with a damaged file, and shows nothing of it", async () => {
  const flip = (share) => (bytes, points) => (bytes[points + 8 + Math.floor(share * (bytes.length - points - 8))] ^= 0x40);
  // Points of format 1 are one stream, those of format 6 a stream for each attribute: coordinates come first.
  assert.match(await openBroken(changed("result_1.laz", flip(0.3))),
               /^broken\.laz cannot be shown: (laz-perf cannot decompress point \d+ of 900|point \d+ )/);
  assert.match(await openBroken(changed("result_6.laz", flip(0.06))), /^broken\.laz cannot be shown: .*bounding box/);
  for (const share of [0.3, 0.6, 0.7]) {
    assert.match(await openBroken(changed("result_6.laz", flip(share))),
                 /^broken\.laz cannot be shown: point \d+ contradicts itself: .* damaged/, `flipped at ${share}`);
  }
  const zeros = changed("result_6.laz", (bytes, points) => bytes.fill(0, points + 500, bytes.length - 100));
  assert.match(await openBroken(zeros), /^broken\.laz cannot be shown: /);
  const box = changed("result_6.laz", (bytes) => bytes.writeDoubleLE(500000, 179));
  assert.match(await openBroken(box), /point \d+ is outside of the bounding box .*: x is 50000\d\.\d+, expected .* to 500000/);
  assert.deepEqual(tab.errors, []);
});

testOfCodec("shows no other curvature for a flipped bit", async () => {
  const path = writeReport("result_6.laz", "report.html");
  await tab.open(path, READY);
  const told = await tab.evaluate(`(async () => {
    const report = ${partOf(path, "report")};
    const good = Uint8Array.from(atob(${JSON.stringify(partOf(path, "points"))}), (c) => c.charCodeAt(0));
    const made = (bytes) => curvLaz.readLaz(structuredClone(report), bytes, () => {});
    const expected = await made(good);
    const points = new DataView(good.buffer).getUint32(96, true) + 8;
    const told = { errors: 0, same: 0, others: {} };
    for (let flip = 0; flip < 150; flip++) {
      const bytes = good.slice();
      bytes[points + Math.floor((flip / 150) * (good.length - points))] ^= 1 << (flip % 8);
      let arrays;
      try {
        ({ arrays } = await made(bytes));
      } catch (error) {
        if (!(error instanceof Error)) throw new Error("what is thrown is no Error");
        told.errors += 1;
        continue;
      }
      const most = (name) => arrays[name].reduce((most, code, i) => Math.max(most, Math.abs(code - expected.arrays[name][i])), 0);
      const changed = Object.keys(arrays).filter((name) => most(name) > 0);
      if (changed.length === 0) told.same += 1;
      for (const name of changed) told.others[name] = Math.max(told.others[name] ?? 0, most(name));
    }
    return { ...told, columns: expected.report.quantities.map(({ column }) => column) };
  })()`);
  assert.ok(told.errors > 75 && told.errors + told.same < 150, JSON.stringify(told));
  for (const [name, most] of Object.entries(told.others)) {
    const column = told.columns[name.match(/^quantity(\d+)$/)?.[1]] ?? name;
    // Nothing in the file tells that these are damaged. The page does not mind the last bits of the others.
    if (["gaussian_curvature", "radius", "normal_u", "normal_v"].includes(column)) continue;
    assert.ok(most <= 1, `${column} is off by ${most} codes`);
  }
});

testOfCodec("names a hostile file as text", async () => {
  const name = "<img src=x onerror=window.harm=1>.laz";
  const said = await openBroken(changed("result_6.laz", (bytes) => bytes.writeDoubleLE(500000, 179)), name);
  assert.ok(said.startsWith(`${name} cannot be shown`), said);
  assert.equal(await tab.evaluate("window.harm"), undefined);
  assert.equal(await tab.evaluate("document.querySelectorAll('img').length"), 0);
});

testOfCodec("makes no page of a file whose header cannot be", () => {
  const cases = [
    [/number of point records is 1000000000/, (bytes) => {
      bytes.writeUInt32LE(0, 107);
      bytes.writeBigUInt64LE(1_000_000_000n, 247);
    }],
    [/the file holds no points/, (bytes) => {
      bytes.writeUInt32LE(0, 107);
      bytes.writeBigUInt64LE(0n, 247);
    }],
    [/table of compressed chunks is at byte/, (bytes, points) => bytes.writeBigInt64LE(1n << 40n, points)],
    [/table of compressed chunks has 4294967295 of them: expected 1/, (bytes, points) =>
      bytes.writeUInt32LE(0xffffffff, Number(bytes.readBigInt64LE(points)) + 4)],
    [/bounding box goes from .* to NaN along X/i, (bytes) => bytes.writeDoubleLE(NaN, 179)],
  ];
  for (const [said, change] of cases) {
    writeFileSync(inFolder("broken.laz"), changed("result_6.laz", change));
    const { status, stderr } = report("broken.laz");
    assert.equal(status, 3, stderr);
    assert.match(stderr, said);
    assert.match(stderr, /broken\.laz: /);
  }
  const whole = readFileSync(fileOf("result_6.laz"));
  for (let size = 0; size < whole.length; size += 4999) {
    writeFileSync(inFolder("broken.laz"), whole.subarray(0, size));
    assert.equal(report("broken.laz").status, 3, `the first ${size} bytes`);
  }
});

const report = (name) => spawnSync(process.env.CURV_BINARY, ["report", inFolder(name), "-o", inFolder("none.html")],
                                   { encoding: "utf8" });

testOfCodec("is served by curv view, and followed when the file changes", async () => {
  copyFileSync(fileOf("result_6.laz"), inFolder("watched.laz"));
  const { child, address } = await view("watched.laz", "--watch");
  running.push(child);
  const other = await browser.openTab(820, 600);
  await other.open(address, READY);
  assert.deepEqual(other.requests.filter((url) => !url.startsWith("data:")).slice(0, 3),
                   [address, `${address}/report`, `${address}/points/1`]);
  const ok = rows.findIndex(({ status }) => status === "ok");
  await askFor(other, ok);
  expectValue((await pointTable(other))["Principal curvature k₂"], rows[ok].k2, "k2");

  const replace = (bytes) => {
    writeFileSync(inFolder("next.laz"), bytes);
    renameSync(inFolder("next.laz"), inFolder("watched.laz"));
  };
  replace(changed("result_6.laz", (bytes) => bytes.writeDoubleLE(500000, 179)));
  await other.waitFor(FAILED);
  assert.match(await other.evaluate(FAILED), /^watched\.laz cannot be shown: point \d+ is outside/);
  expectValue((await pointTable(other))["Principal curvature k₂"], rows[ok].k2, "k2 of the version before");
  replace(readFileSync(fileOf("terrain_7.laz")));
  await other.waitFor("document.documentElement.dataset.generation === '3'");
  assert.equal(await other.evaluate(FAILED), undefined);
  assert.equal(await other.evaluate("document.getElementById('subtitle').textContent"), "300 points");
  assert.equal(await other.evaluate("document.getElementById('quantity').options[0].textContent"), "intensity");
  assert.deepEqual(other.errors, []);
});

test("is packed by gzip, and chosen by what is in the file", async () => {
  writeFileSync(inFolder("packed.laz.gz"), execFileSync("gzip", ["-c", fileOf("result_6.laz")]));
  copyFileSync(fileOf("result_6.laz"), inFolder("compressed.las"));
  for (const name of ["packed.laz.gz", "compressed.las"]) {
    await tab.open(writeReport(name, "report.html"), READY);
    assert.equal(await tab.evaluate("document.getElementById('subtitle').textContent"), "900 points");
  }
});
