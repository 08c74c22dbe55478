#!/usr/bin/env node
// Makes plain LAS of LAZ or COPC, for curv and other programs that read LAS alone. Exit codes are those of curv.
import { readFile, rename, rm, writeFile } from "node:fs/promises";
import { plainLas } from "./las_plain.mjs";

const USAGE = "usage: curvd-las IN.laz OUT.las\n\nDecompresses a LAZ or COPC file by the package laz-perf: the same points, attributes and records.";

function fail(code, message) {
  console.error(`curvd-las: ${message}`);
  process.exit(code);
}

const paths = process.argv.slice(2);
if (paths.includes("--help") || paths.includes("-h")) {
  console.log(USAGE);
  process.exit(0);
}
if (paths.length !== 2 || paths.some((path) => path.startsWith("-"))) fail(2, USAGE);
const [input, output] = paths;
if (!/\.las$/i.test(output)) fail(2, `OUT.las is ${output}; it must end in .las`);

let plain;
try {
  plain = await plainLas(await readFile(input));
} catch (error) {
  fail(3, `${input}: ${error.message}`);
}
const partial = `${output}.partial`;
try {
  await writeFile(partial, plain);
  await rename(partial, output);
} catch (error) {
  await rm(partial, { force: true });
  fail(4, error.message);
}
