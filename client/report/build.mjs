// Makes page.html, which `curv report` writes results into, of page/ and three.js, and laz_codec.html, which pages of
// compressed points have beside it, of laz/ and laz-perf: node build.mjs [--check]
// --check makes nothing and fails where they are not what it would make.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = dirname(fileURLToPath(import.meta.url));
const read = (...names) => readFileSync(join(folder, ...names), "utf8");
const PLACES = ["@curv-connect@", "@curv-codec-policy@", "@curv-report@", "@curv-points@", "@curv-codec@"];

// Each line of a module about WebAssembly as text in base64: what esbuild calls "binary" it would unpack by itself.
const asBase64 = {
  name: "base64",
  setup: ({ onLoad }) => onLoad({ filter: /\.wasm$/ }, ({ path }) => ({
    contents: `export default ${JSON.stringify(readFileSync(path).toString("base64"))}`,
  })),
};

async function bundle(entry, globalName) {
  const { outputFiles } = await build({
    entryPoints: [join(folder, entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    globalName,
    target: "es2020",
    charset: "ascii",
    legalComments: "none",
    plugins: [asBase64],
    absWorkingDir: folder,
  });
  // The first `</script` would end the element.
  const script = outputFiles[0].text.trim().replaceAll("</script", "<\\/script");
  if (script.includes("<!--")) throw new Error(`${entry} makes a script with <!--, which starts a comment in it`);
  return script;
}

const hashOf = (script) => `'sha256-${createHash("sha256").update(script).digest("base64")}'`;

const licenseOf = (what, text) => `${what} is part of this page.\n\n${text.trim()}`.replaceAll("--", "- -");

function fill(template, parts) {
  return template.replace(/%([A-Z]+)%/g, (place, name) => {
    if (!(name in parts)) throw new Error(`page/index.html has ${place}, for which there is nothing`);
    return parts[name];
  });
}

async function makePage() {
  const script = await bundle("page/main.mjs");
  const page = fill(read("page", "index.html"), {
    POLICY: `default-src 'none'; @curv-connect@script-src ${hashOf(script)}@curv-codec-policy@; ` +
      "style-src 'unsafe-inline'; img-src data:",
    STYLE: read("page", "style.css").trim(),
    SCRIPT: script,
    LICENSE: licenseOf("three.js", read("node_modules", "three", "LICENSE")),
  });
  let last = -1;
  for (const place of PLACES) {
    if (page.split(place).length !== 2) throw new Error(`${place} must stand once in the page`);
    if (page.indexOf(place) < last) throw new Error(`${place} must stand behind those before it in ${PLACES}`);
    last = page.indexOf(place);
  }
  return page;
}

// What the policy allows beside the page's script, on a line of its own; then what the page holds.
async function makeCodec() {
  const script = await bundle("laz/codec.mjs", "curvLaz");
  const license = licenseOf("laz-perf (https://github.com/hobuinc/laz-perf)", read("laz", "LICENSE-laz-perf"));
  return ` ${hashOf(script)} 'wasm-unsafe-eval'\n<!--\n${license}\n-->\n<script>${script}</script>\n`;
}

for (const [name, text] of [["page.html", await makePage()], ["laz_codec.html", await makeCodec()]]) {
  if (process.argv[2] !== "--check") {
    writeFileSync(join(folder, name), text);
    console.log(`client/report/${name}: ${text.length} bytes`);
  } else if (read(name) !== text) {
    console.error(`client/report/${name} is not what its sources make: run \`make report-page\``);
    process.exitCode = 1;
  }
}
