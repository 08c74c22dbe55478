// What pages of compressed points have beside page/: decompresses a LAZ or COPC file, and makes the report of it that
// curv makes of a file that it can read.
import createLazPerf from "laz-perf/lib/web/laz-perf.js";
import wasm from "laz-perf/lib/laz-perf.wasm";
import { takeRecords } from "../../node/laz_records.mjs";
import { bytesOfBase64 } from "../page/bytes.mjs";
import { pauses } from "./pauses.mjs";
import { makeReport } from "./make_report.mjs";
import { BoxCheck } from "./checks.mjs";

async function startCodec() {
  const silent = () => {};
  return createLazPerf({ wasmBinary: bytesOfBase64(wasm), print: silent, printErr: silent });
}

/** Resolves to { report, arrays, indices }, what a page shows, of what curv wrote about a compressed file and the file's
 * bytes. `tell(text)` is called with what is going on. Rejects with an Error that says what is wrong with the file. */
export async function readLaz(report, file, tell) {
  const { layout } = report.laz;
  const pause = pauses();
  const box = new BoxCheck(layout);
  tell("Decompressing the points …");
  const records = await takeRecords(await startCodec(), file, report.points, layout.recordBytes, (all, begin, end) => {
    box.check(all, begin, end);
    return pause(() => tell(`Decompressing the points: ${Math.floor((100 * end) / report.points)} % …`));
  });
  return makeReport(report, records, box, tell, pause);
}
