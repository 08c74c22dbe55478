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

/** Clicks where the page marks the chosen point. */
export async function clickMarker(tab) {
  const [x, y] = await tab.evaluate(`(() => {
    const [marker, box] = ["marker", "view"].map((id) => document.getElementById(id));
    const { left, top } = box.getBoundingClientRect();
    return [left + Number(marker.getAttribute("cx")), top + Number(marker.getAttribute("cy"))];
  })()`);
  await tab.click(x, y);
}

/** The rows of the table about the chosen point: what stands beside each name. */
export const pointTable = (tab) => tab.evaluate(`Object.fromEntries(
  [...document.querySelectorAll("#point tr")].map((row) => [row.cells[0].textContent, row.cells[1].textContent]))`);

// The least ratio of WCAG 2.1, 1.4.3: 4.5 for text. Colors are opaque, but for the legend's background.
export const LOWEST_CONTRAST = `(() => {
  const levels = (text) => text.match(/[\\d.]+/g).slice(0, 3).map((c) => c / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  const light = (text) => levels(text).reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const backdrop = (element) => {
    const color = getComputedStyle(element).backgroundColor;
    if (/^rgb\\(/.test(color)) return color;
    return element.parentElement ? backdrop(element.parentElement) : "rgb(255, 255, 255)";
  };
  const texts = [...document.querySelectorAll("body *")].filter((element) =>
    element.checkVisibility() && !element.closest("script, svg, select, [disabled]") &&
    [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim()));
  return texts.map((element) => {
    const [a, b] = [light(getComputedStyle(element).color), light(backdrop(element))];
    return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), element.textContent.slice(0, 40)];
  }).sort((a, b) => a[0] - b[0])[0];
})()`;

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
