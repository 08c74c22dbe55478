// Says how large a report is, and how long a browser takes with it, or with what curv view serves at an address:
// measure.mjs REPORT.html|ADDRESS [SCREENSHOT.png]
import { readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { gzipSync } from "node:zlib";
import { Browser, findBrowser } from "./browser.mjs";
import { READY } from "./helpers.mjs";

const [report, screenshot] = process.argv.slice(2);
const isServed = report.startsWith("http:");
const megabytes = (count) => `${(count / 1e6).toFixed(2)} MB`;
const browser = await Browser.start(findBrowser());
try {
  const tab = await browser.openTab(1280, 800);
  await tab.open(isServed ? report : resolve(report), READY, 300);
  const { picture, ready } = await tab.evaluate("({ ...document.documentElement.dataset })");
  const bytes = isServed ? null : readFileSync(report);
  const size = bytes ? `${megabytes(bytes.length)}, ${megabytes(gzipSync(bytes).length)} gzipped; ` : "";
  console.log(`${report}: ${size}first picture after ${picture} ms, all points after ${ready} ms`);
  if (screenshot) writeFileSync(screenshot, await tab.screenshot());
} finally {
  await browser.close();
}
