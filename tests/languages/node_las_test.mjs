// Files of surveys. The LAS, LAZ and COPC files are those that PDAL wrote; against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { estimateCurvature, readPointCloud } from "../../client/node/index.mjs";

const server = process.env.CURVD_SERVER;
const nodeClient = fileURLToPath(new URL("../../client/node", import.meta.url));
const fileOf = (name) => fileURLToPath(new URL(`../client/io/las/pdal/${name}`, import.meta.url));
const bytesOf = (name) => new Uint8Array(readFileSync(fileOf(name)));

// The file with one field changed: write(view) gets a DataView of its bytes.
function changed(name, write) {
  const bytes = bytesOf(name);
  write(new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength));
  return bytes;
}

test("a LAS file gives the positions and normals that it was made of", async () => {
  const { positions, normals, pointCount } = await readPointCloud(fileOf("terrain_3.las"));
  assert.equal(pointCount, 300);
  assert.deepEqual([...positions.subarray(0, 3)], [500012.611, 5800019.068, 100.018]);
  assert.equal(normals[0], Math.fround(-0.3643637));
  for (let i = 0; i < 300; i++) assert.ok(Math.abs(Math.hypot(...normals.subarray(3 * i, 3 * i + 3)) - 1) < 1e-6);
});

test("LAZ and COPC hold the points of the LAS files that they were made of", async () => {
  const pairs = [["terrain_3.las", "terrain_3.laz"], ["terrain_7.las", "terrain_7.laz"], ["terrain_7.las", "terrain_7.copc.laz"]];
  for (const [plain, compressed] of pairs) {
    assert.deepEqual(await readPointCloud(bytesOf(compressed)), await readPointCloud(bytesOf(plain)), compressed);
  }
});

test("what was read can be estimated", async () => {
  const { positions, normals } = await readPointCloud(fileOf("terrain_7.copc.laz"));
  const { status, meanCurvature } = await estimateCurvature(positions, normals, { server, neighborCount: 20 });
  assert.equal(status.length, 300);
  assert.ok(meanCurvature.filter(Number.isFinite).length > 290);
});

test("a file without normals has none", async () => {
  const renamed = changed("terrain_3.las", (view) => view.setUint8(view.getUint16(94, true) + 54 + 4, 0x78));
  assert.equal((await readPointCloud(renamed)).normals, null);
});

test("scale and offset of extra bytes hold", async () => {
  const descriptor = (view) => view.getUint16(94, true) + 54;
  const scaled = changed("terrain_3.las", (view) => {
    view.setUint8(descriptor(view) + 3, 24);
    view.setFloat64(descriptor(view) + 112, 2, true);
    view.setFloat64(descriptor(view) + 136, 10, true);
  });
  const { normals } = await readPointCloud(scaled);
  assert.equal(normals[0], 2 * Math.fround(-0.3643637) + 10);
});

test("wrong files are refused, and say what is wrong", async () => {
  const cases = [
    [new Uint8Array(500), /signature of the file is ""/],
    [bytesOf("terrain_3.las").subarray(0, 100), /ends after 100 bytes/],
    [bytesOf("terrain_3.las").subarray(0, 5000), /ends too early: the number of point records is 300, 46 bytes each/],
    [changed("terrain_3.las", (view) => view.setUint8(25, 5)), /version is 1\.5/],
    [changed("terrain_3.las", (view) => view.setUint8(104, 11)), /format is 11/],
    [changed("terrain_3.las", (view) => view.setUint16(105, 20, true)), /record length is 20/],
    [changed("terrain_3.las", (view) => view.setFloat64(131, 0, true)), /X scale factor is 0/],
    [changed("terrain_3.las", (view) => view.setUint32(100, 1000, true)), /variable length record/],
    [changed("terrain_3.laz", (view) => view.setUint32(107, 0xffffff, true)), /16777215/],
    [bytesOf("terrain_7.laz").subarray(0, 6000), /laz-perf cannot decompress point/],
  ];
  for (const [bytes, expected] of cases) await assert.rejects(readPointCloud(bytes), expected);
  await assert.rejects(readPointCloud("missing.las"), /missing\.las/);
  await assert.rejects(readPointCloud(5), TypeError);
  await assert.rejects(readPointCloud(fileOf("README.md")), /README\.md: the signature/);
});

test("curvd-las makes the LAS file that was compressed", (context) => {
  const folder = mkdtempSync(path.join(tmpdir(), "curvd-las-"));
  context.after(() => rmSync(folder, { recursive: true }));
  const run = (...words) =>
    spawnSync(process.execPath, [path.join(nodeClient, "curvd-las.mjs"), ...words], { cwd: folder, encoding: "utf8" });
  const made = (name) => {
    const { status, stderr } = run(fileOf(name), "out.las");
    assert.equal(status, 0, stderr);
    return readFileSync(path.join(folder, "out.las"));
  };
  const points = (bytes) => bytes.subarray(bytes.readUInt32LE(96));
  assert.deepEqual(made("terrain_3.laz"), readFileSync(fileOf("terrain_3.las")));
  const plain = readFileSync(fileOf("terrain_7.las"));
  plain.fill(0, 235, 243); // where extended records would start, of which there are none
  assert.deepEqual(made("terrain_7.laz"), plain);
  const copc = made("terrain_7.copc.laz");
  assert.deepEqual(points(copc), points(plain));
  assert.deepEqual([copc.readUInt32LE(100), copc.readUInt32LE(243)], [2, 0]);
  assert.doesNotMatch(copc.toString("latin1"), /copc|laszip encoded/);

  const cases = [
    [2, /usage: curvd-las IN\.laz OUT\.las/, ["in.laz"]],
    [2, /must end in \.las/, [fileOf("terrain_3.laz"), "out.laz"]],
    [3, /is a LAS file already/, [fileOf("terrain_3.las"), "out.las"]],
    [3, /no such file/, ["missing.laz", "out.las"]],
    [4, /no such file/, [fileOf("terrain_3.laz"), "nowhere/out.las"]],
  ];
  for (const [code, said, words] of cases) {
    const { status, stderr } = run(...words);
    assert.equal(status, code, stderr);
    assert.match(stderr, said);
  }
  assert.match(run("--help").stdout, /^usage/);
});

test("without laz-perf a LAZ file says what to install", (context) => {
  const folder = mkdtempSync(path.join(tmpdir(), "curvd-laz-"));
  context.after(() => rmSync(folder, { recursive: true }));
  for (const name of ["las.mjs", "laz.mjs", "laz_records.mjs"]) cpSync(path.join(nodeClient, name), path.join(folder, name));
  const program = `import { readPointCloud } from "./las.mjs";
    console.log((await readPointCloud(${JSON.stringify(fileOf("terrain_3.las"))})).pointCount);
    await readPointCloud(${JSON.stringify(fileOf("terrain_3.laz"))}).catch((error) => console.log(error.message));`;
  const said = execFileSync(process.execPath, ["--input-type=module", "-e", program], { cwd: folder, encoding: "utf8" });
  assert.match(said, /^300\n.*terrain_3\.laz: .*install the package laz-perf/);
});
