// The package in an empty folder, as somebody has it who has no clone. Against a real curvd (CURVD_SERVER).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const source = fileURLToPath(new URL("../../client/node", import.meta.url));
const compiler = path.join(source, "node_modules/typescript/bin/tsc");

const PROGRAM = `
import { CurvatureClient, CurvdError, PointStatus } from "curvd-client";

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
  await client.estimateCurvature(positions, normals, { neighborCount: 3000000 });
} catch (error) {
  if (!(error instanceof CurvdError)) throw error;
  console.log(error.reason);
} finally {
  client.close();
}
`;

test("the package works in an empty folder, and its types hold", (context) => {
  const folder = mkdtempSync(path.join(tmpdir(), "curvd-package-"));
  context.after(() => rmSync(folder, { recursive: true }));
  const run = (command, ...args) => execFileSync(command, args, { cwd: folder, encoding: "utf8" });

  const packed = execFileSync("npm", ["pack", "--silent", "--pack-destination", folder], { cwd: source, encoding: "utf8" });
  assert.ok(!existsSync(path.join(source, "proto")), "the copy of the contract is gone again");
  // What `npm install TARBALL` does, without a network.
  cpSync(path.join(source, "node_modules"), path.join(folder, "node_modules"), { recursive: true });
  const installed = path.join(folder, "node_modules/curvd-client");
  mkdirSync(installed);
  run("tar", "-xzf", packed.trim(), "-C", installed, "--strip-components=1");
  assert.ok(!existsSync(path.join(installed, "pack.mjs")));

  writeFileSync(path.join(folder, "program.mts"), PROGRAM);
  const strict = ["--strict", "--exactOptionalPropertyTypes", "--noUncheckedIndexedAccess"];
  const modules = ["--module", "nodenext", "--target", "es2022", "--types", "node"];
  run(process.execPath, compiler, ...strict, ...modules, "program.mts");
  assert.equal(run(process.execPath, "program.mjs"), "0.5 true 1000\nNEIGHBORHOOD_TOO_LARGE\n");

  writeFileSync(path.join(folder, "wrong.mts"), PROGRAM.replaceAll("neighborCount", "neighbourCount"));
  assert.throws(
    () => run(process.execPath, compiler, "--noEmit", ...strict, ...modules, "wrong.mts"),
    (error) => /'neighbourCount' does not exist in type 'CurvatureOptions'/.test(error.stdout),
  );
});
