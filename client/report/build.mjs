// Makes page.html, which `curv report` writes results into, of page/ and three.js: node build.mjs [--check]
// --check makes nothing and fails where page.html is not what it would make.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = dirname(fileURLToPath(import.meta.url));
const read = (...names) => readFileSync(join(folder, ...names), "utf8");
const PLACES = ["@curv-connect@", "@curv-report@", "@curv-points@"];

async function bundle() {
  const { outputFiles } = await build({
    entryPoints: [join(folder, "page", "main.mjs")],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: "es2020",
    charset: "ascii",
    legalComments: "none",
    absWorkingDir: folder,
  });
  // The first `</script` would end the element.
  return outputFiles[0].text.trim().replaceAll("</script", "<\\/script");
}

function fill(template, parts) {
  return template.replace(/%([A-Z]+)%/g, (place, name) => {
    if (!(name in parts)) throw new Error(`page/index.html has ${place}, for which there is nothing`);
    return parts[name];
  });
}

async function makePage() {
  const script = await bundle();
  const hash = createHash("sha256").update(script).digest("base64");
  const license = `three.js is part of this page.\n\n${read("node_modules", "three", "LICENSE").trim()}`;
  const page = fill(read("page", "index.html"), {
    POLICY: `default-src 'none'; @curv-connect@script-src 'sha256-${hash}'; style-src 'unsafe-inline'; img-src data:`,
    STYLE: read("page", "style.css").trim(),
    SCRIPT: script,
    LICENSE: license.replaceAll("--", "- -"),
  });
  for (const place of PLACES) {
    if (page.split(place).length !== 2) throw new Error(`${place} must stand once in the page`);
  }
  return page;
}

const page = await makePage();
const target = join(folder, "page.html");
if (process.argv[2] !== "--check") {
  writeFileSync(target, page);
  console.log(`client/report/page.html: ${page.length} bytes`);
} else if (read("page.html") !== page) {
  console.error("client/report/page.html is not what its sources make: run `make report-page`");
  process.exit(1);
}
