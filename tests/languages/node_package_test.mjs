// The package in an empty folder, as somebody has it who has no clone. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const source = fileURLToPath(new URL("../../client/node", import.meta.url));
const root = path.join(source, "../..");
const server = process.env.CURVD_SERVER;
const compiler = path.join(source, "node_modules/typescript/bin/tsc");

const PROGRAM = `
import { CurvatureClient, CurvdError, PointStatus, readPointCloud, type PointCloud, type ResultChunk } from "curvd-client";

const read: (file: string) => Promise<PointCloud> = readPointCloud;

const positions = new Float32Array(3 * 1000), normals = new Float32Array(3 * 1000);
for (let i = 0; i < 1000; i++) {
  const z = 1 - (2 * i + 1) / 1000, turn = 2.4 * i, ring = Math.sqrt(1 - z * z);
  normals.set([ring * Math.cos(turn), ring * Math.sin(turn), z], 3 * i);
}
positions.set(normals.map((component) => 2 * component));
const client = new CurvatureClient(process.env["CURVD_SERVER"]);
try {
  const { meanCurvature, status, summary } = await client.estimateCurvature(positions, normals, { neighborCount: 30 });
  const mean = meanCurvature?.[0] ?? NaN;
  console.log(mean.toFixed(1), status[0] === PointStatus.OK, summary.pointCount);
  const chunks = client.estimateChunks(positions, normals, { neighborCount: 30 });
  for await (const chunk of chunks) {
    const { firstIndex, status }: ResultChunk = chunk;
    console.log(firstIndex, status.length, await client.health());
  }
  console.log(chunks.summary?.pointCount);
  await client.estimateCurvature(positions, normals, { neighborCount: 3000000 });
} catch (error) {
  if (!(error instanceof CurvdError)) throw error;
  console.log(error.reason);
} finally {
  client.close();
}
`;

test("the package is installed in an empty folder by npm, works there, and its types hold", (context) => {
  const folder = mkdtempSync(path.join(tmpdir(), "curvd-package-"));
  context.after(() => rmSync(folder, { recursive: true }));
  const run = (command, ...args) => execFileSync(command, args, { cwd: folder, encoding: "utf8" });

  const packed = execFileSync("npm", ["pack", "--silent", "--pack-destination", folder], { cwd: source, encoding: "utf8" });
  assert.ok(!existsSync(path.join(source, "proto")), "the copy of the contract is gone again");
  // What it needs beside lies in npm's cache since `npm ci`, but for what the registry says of versions.
  const quiet = ["--prefer-offline", "--no-audit", "--no-fund", "--silent"];
  writeFileSync(path.join(folder, "package.json"), "{}");
  cpSync(path.join(source, ".npmrc"), path.join(folder, ".npmrc"));
  run("npm", "install", ...quiet, `./${packed.trim()}`);
  const installed = path.join(folder, "node_modules/curvd-client");
  assert.ok(!existsSync(path.join(installed, "pack.mjs")));
  const { version } = JSON.parse(readFileSync(path.join(installed, "package.json"), "utf8"));
  assert.equal(version, /^project\(curvd VERSION (\S+)/m.exec(readFileSync(path.join(root, "CMakeLists.txt"), "utf8"))[1]);

  assert.match(run(path.join(folder, "node_modules/.bin/curvd-las"), "--help"), /^usage: curvd-las/);

  // README's program, as who has installed the package writes it.
  const readme = readFileSync(path.join(root, "README.md"), "utf8");
  const snippet = /^```js\n(.*?)^```$/ms.exec(readme)[1];
  const own = snippet.replace("./client/node/index.mjs", "curvd-client").replaceAll("localhost:50061", server);
  assert.ok(own.includes('from "curvd-client"') && own.includes(server), own);
  writeFileSync(path.join(folder, "readme.mjs"), own);
  const [first, ...rest] = run(process.execPath, "readme.mjs").split("\n");
  assert.match(first, /^0\.5\d* 1 10000$/);
  assert.match(rest.join("\n"), /^INVALID_ARGUMENT INVALID_OPTION /);

  writeFileSync(path.join(folder, "program.mts"), PROGRAM);
  const strict = ["--strict", "--exactOptionalPropertyTypes", "--noUncheckedIndexedAccess"];
  const modules = ["--module", "nodenext", "--target", "es2022", "--types", "node"];
  run(process.execPath, compiler, ...strict, ...modules, "program.mts");
  assert.equal(run(process.execPath, "program.mjs"), "0.5 true 1000\n0 1000 SERVING\n1000\nNEIGHBORHOOD_TOO_LARGE\n");

  writeFileSync(path.join(folder, "wrong.mts"), PROGRAM.replaceAll("neighborCount", "neighbourCount"));
  assert.throws(
    () => run(process.execPath, compiler, "--noEmit", ...strict, ...modules, "wrong.mts"),
    (error) => /'neighbourCount' does not exist in type 'CurvatureOptions'/.test(error.stdout),
  );
});
