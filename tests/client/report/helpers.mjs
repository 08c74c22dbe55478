// What the tests of the page share: results in files, and a page with its report in a browser.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { readPng } from "./picture.mjs";

const curv = process.env.CURV_BINARY;
export const folder = mkdtempSync(join(tmpdir(), "curv-report-"));
export const removeFolder = () => rmSync(folder, { recursive: true, force: true });
export const inFolder = (name) => join(folder, name);

export function runCurv(...args) {
  return execFileSync(curv, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

/** Writes the report of a result; returns its path. */
export function writeReport(result, name, ...flags) {
  runCurv("report", inFolder(result), "-o", inFolder(name), ...flags);
  return inFolder(name);
}

/** The rows of a CSV file as objects, numbers as numbers. */
export function readCsv(name) {
  const [head, ...lines] = readFileSync(inFolder(name), "utf8").trim().split("\n");
  const names = head.split(",");
  return lines.map((line) => Object.fromEntries(line.split(",").map((field, i) =>
    [names[i], names[i] === "status" ? field : Number(field)])));
}

export const READY = "document.documentElement.dataset.ready && document.documentElement.dataset.drawn === 'smooth'";

/** What the picture of the cloud shows once all of it is drawn, without what lies over it. */
export async function pictureOf(tab) {
  // Two frames later whatever an event asked for has begun.
  await tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
  await tab.waitFor("document.documentElement.dataset.drawn === 'smooth'");
  const setOpacity = (opacity) => tab.evaluate(`for (const id of ["overlay", "legend", "progress"]) {
    document.getElementById(id).style.opacity = "${opacity}";
  }`);
  await setOpacity(0);
  const picture = readPng(await tab.screenshot("#view"));
  await setOpacity("");
  return picture;
}

/** Chooses an entry of a menu, as a person does who has opened it. */
export const choose = (tab, id, value) => tab.evaluate(`(() => {
  const menu = document.getElementById(${JSON.stringify(id)});
  menu.value = ${JSON.stringify(value)};
  menu.dispatchEvent(new Event("change", { bubbles: true }));
})()`);

export const clickOn = (tab, selector) => tab.evaluate(`document.querySelector(${JSON.stringify(selector)}).click()`);

/** Asks the page for the point of an index. */
export const askFor = (tab, index) => tab.evaluate(`(() => {
  document.getElementById("index").value = ${JSON.stringify(String(index))};
  document.querySelector("#goto button").click();
})()`);

/** The rows of the table about the chosen point: what stands beside each name. */
export const pointTable = (tab) => tab.evaluate(`Object.fromEntries(
  [...document.querySelectorAll("#point tr")].map((row) => [row.cells[0].textContent, row.cells[1].textContent]))`);

/** A number as the page writes it, its unit left out. */
export function readNumber(text) {
  const [, digits, power] = text.match(/^([−\d.]+)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/);
  const exponent = [...(power ?? "")].map((c) => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join("");
  return Number(digits.replace("−", "-")) * 10 ** Number(exponent || 0);
}

/** Fails unless `text` is `value` to 0.05 % of binary16 and half a unit of the fourth digit. */
export function expectValue(text, value, name) {
  const error = Math.abs(readNumber(text) - value);
  assert.ok(error <= 1.1e-3 * Math.abs(value) + 1e-12, `${name}: the page says ${text}, the file ${value}`);
}

/** Runs `curv view` on a result; resolves to its process and the address that it prints. */
export async function view(result, ...flags) {
  const child = spawn(curv, ["view", inFolder(result), ...flags], { stdio: ["ignore", "pipe", "inherit"] });
  const [line] = await once(child.stdout, "data");
  return { child, address: line.toString().trim() };
}

/** Fails if the page asked for anything but its file, or said that something is wrong. */
export function expectQuiet(tab, path) {
  assert.deepEqual(tab.errors, []);
  assert.deepEqual(tab.requests.filter((url) => !url.startsWith("data:")), [`file://${encodeURI(path)}`]);
}
