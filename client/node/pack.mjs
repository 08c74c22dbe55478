// Copies the contract into the package before `npm pack` reads it, and takes the copy away afterwards.
import { cpSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";

const copy = fileURLToPath(new URL("./proto", import.meta.url));
rmSync(copy, { recursive: true, force: true });
if (process.argv[2] === "copy") {
  for (const folder of ["curvature", "google"]) {
    const source = fileURLToPath(new URL(`../../proto/${folder}`, import.meta.url));
    cpSync(source, `${copy}/${folder}`, { recursive: true });
  }
}
