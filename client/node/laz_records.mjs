// Takes the points out of LAZ and COPC files by an instance of laz-perf, in Node.js and in the page of `curv report`.

const BATCH = 4096;

/** Resolves to the records of a whole LAZ or COPC file as an uncompressed file holds them, `pointCount` of `recordBytes`
 * bytes each. `codec` comes from createLazPerf; it is of no use any more, for its memory never shrinks, and a damaged file
 * may have broken it. `taken(records, begin, end)` is called, and waited for, when the points from begin on, up to end, are
 * there. Rejects with an Error that says what is wrong; those of `taken` come as they are. */
export async function takeRecords(codec, file, pointCount, recordBytes, taken = () => {}) {
  const input = allocate(codec, file.length);
  const batch = allocate(codec, BATCH * recordBytes);
  const records = new Uint8Array(pointCount * recordBytes);
  let [decoded, reader] = [0, null];
  const decode = (end) => {
    try {
      if (!reader) {
        codec.HEAPU8.set(file, input);
        reader = new codec.LASZip();
        reader.open(input, file.length);
        if (reader.getCount() !== pointCount || reader.getPointLength() !== recordBytes) {
          throw new Error(`it finds ${reader.getCount()} points of ${reader.getPointLength()} bytes`);
        }
      }
      const begin = decoded;
      for (; decoded < end; decoded++) reader.getPoint(batch + (decoded - begin) * recordBytes);
      // Memory that has grown is another array.
      records.set(codec.HEAPU8.subarray(batch, batch + (end - begin) * recordBytes), begin * recordBytes);
    } catch (error) {
      // What C++ throws comes as a number, a memory fault as a RuntimeError.
      const reason = error instanceof Error ? error.message : "it gives no reason";
      throw new Error(`laz-perf cannot decompress point ${decoded} of ${pointCount}: ${reason}`);
    }
  };
  try {
    while (decoded < pointCount) {
      const begin = decoded;
      decode(Math.min(begin + BATCH, pointCount));
      await taken(records, begin, decoded);
    }
  } finally {
    release(codec, reader, [batch, input]);
  }
  return records;
}

function allocate(codec, bytes) {
  const at = codec._malloc(bytes);
  if (at === 0) throw new Error(`laz-perf has no room for a file of ${bytes} bytes: it takes 2 GiB at most`);
  return at;
}

// What a damaged file has broken may refuse to go; it goes with the codec.
function release(codec, reader, blocks) {
  try {
    reader?.delete();
    for (const block of blocks) codec._free(block);
  } catch {}
}
