// Decompresses the points of LAZ and COPC files by the package laz-perf, if it is installed.

/** Resolves to the records of a whole LAZ or COPC file as an uncompressed file holds them, `pointCount` of `recordBytes`
 * bytes each. Rejects with an Error that says what is missing or wrong. */
export async function decompress(file, pointCount, recordBytes) {
  const codec = await loadCodec();
  const records = new Uint8Array(pointCount * recordBytes);
  const input = allocate(codec, file.length);
  const record = allocate(codec, recordBytes);
  let decoded = 0;
  let reader;
  try {
    codec.HEAPU8.set(file, input);
    reader = new codec.LASZip();
    reader.open(input, file.length);
    if (reader.getCount() !== pointCount || reader.getPointLength() !== recordBytes) {
      throw new Error(`it finds ${reader.getCount()} points of ${reader.getPointLength()} bytes`);
    }
    for (; decoded < pointCount; decoded++) {
      reader.getPoint(record);
      // Memory that has grown is another array.
      records.set(codec.HEAPU8.subarray(record, record + recordBytes), decoded * recordBytes);
    }
  } catch (error) {
    // What C++ throws comes as a number, a memory fault as a RuntimeError.
    const reason = error instanceof Error ? error.message : "it gives no reason";
    throw new Error(`laz-perf cannot decompress point ${decoded} of ${pointCount}: ${reason}`);
  } finally {
    reader?.delete();
    codec._free(record);
    codec._free(input);
  }
  return records;
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

function allocate(codec, bytes) {
  const at = codec._malloc(bytes);
  if (at === 0) throw new Error(`laz-perf has no room for a file of ${bytes} bytes: it takes 2 GiB at most`);
  return at;
}
