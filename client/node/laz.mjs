// Decompresses the points of LAZ and COPC files by the package laz-perf, if it is installed.
import { takeRecords } from "./laz_records.mjs";

/** Resolves to the records of a whole LAZ or COPC file as an uncompressed file holds them, `pointCount` of `recordBytes`
 * bytes each. Rejects with an Error that says what is missing or wrong. */
export async function decompress(file, pointCount, recordBytes) {
  return takeRecords(await loadCodec(), file, pointCount, recordBytes);
}

// One for each file, so that its memory, which never shrinks, goes with it, and nothing outlives a file that broke it.
async function loadCodec() {
  let codec;
  try {
    codec = await import("laz-perf");
  } catch (error) {
    if (error.code !== "ERR_MODULE_NOT_FOUND") throw error;
    throw new Error("the points are compressed (LAZ or COPC): install the package laz-perf, which decompresses them", {
      cause: error,
    });
  }
  return codec.createLazPerf();
}
