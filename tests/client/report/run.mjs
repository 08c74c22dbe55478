// Runs the tests of the page in a browser; ends with 77, which CTest knows as skipped, where there is none.
import { spawnSync } from "node:child_process";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { findBrowser } from "./browser.mjs";

if (!findBrowser()) {
  console.log("skipped: no chromium to open the page with (apt-get install chromium, or set CURVD_CHROMIUM)");
  process.exit(77);
}
const folder = dirname(fileURLToPath(import.meta.url));
const tests = ["report_page_test.mjs", "report_looks_test.mjs", "report_view_test.mjs", "report_laz_test.mjs"].map((name) => join(folder, name));
process.exit(spawnSync(process.execPath, ["--test", ...tests], { stdio: "inherit" }).status ?? 1);
