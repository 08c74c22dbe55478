// Collects the results of a call into typed arrays and checks that none is missing.
import { CURVATURE_ARRAYS, RESULT_ARRAYS } from "./protocol.mjs";

// What became of a point; the values of `status` in the result.
export const PointStatus = Object.freeze({
  OK: 1,
  TOO_FEW_NEIGHBORS: 2,
  DEGENERATE_AREA: 3,
  INVALID_INPUT: 4,
  INCONSISTENT_NORMALS: 5,
  SINGULAR_FIT: 6,
  OPPOSED_NORMALS: 7,
  OUTLIER: 8,
});

// Takes ResultChunks in order. Throws, saying what is wrong, if a server breaks the protocol.
//
// `arrays` has a Uint8Array for `status` and a Float32Array for each array of `names`, without which a chunk is refused;
// where `names` is null, for each that comes. How many scalars a point has in an array follows from the length of the
// first chunk's, and must not change. Of an empty cloud all arrays are empty; those of normals are there if they are among
// `names`, or if `names` is null and `madeNormals` says that the server makes or turns normals.
export class ResultCollector {
  #received = 0;
  #pointCount;
  #names;
  #widths = {};

  constructor(pointCount, names = null, madeNormals = false) {
    this.#pointCount = pointCount;
    this.#names = names;
    this.arrays = { status: new Uint8Array(pointCount) };
    if (pointCount > 0) return;
    for (const name of names ?? [...CURVATURE_ARRAYS, ...(madeNormals ? ["normal"] : [])]) {
      this.arrays[name] = new Float32Array();
    }
  }

  get isComplete() {
    return this.#received === this.#pointCount;
  }

  add(chunk) {
    const begin = chunk.firstIndex;
    const end = checkPlace(chunk, this.#received, this.#pointCount);
    if (begin === 0) this.#makeArrays(chunk);
    for (const name of RESULT_ARRAYS) {
      // What nobody asked for comes from servers that are older than the question.
      if (this.#names === null || name === "status" || this.#names.includes(name)) {
        this.#store(name, chunk[name], begin, end);
      }
    }
    this.#received = end;
  }

  #makeArrays(chunk) {
    this.#widths.status = 1;
    for (const name of this.#names ?? RESULT_ARRAYS) {
      if (name === "status") continue;
      if (chunk[name].length === 0) {
        if (this.#names === null) continue;
        throw new Error(`the results are without ${name}, which the call asked for`);
      }
      const width = chunk[name].length / (chunk.pointCount * Float32Array.BYTES_PER_ELEMENT);
      if (!Number.isInteger(width)) {
        throw new Error(`${name} of ${chunk.pointCount} points has ${chunk[name].length} bytes, which are no floats`);
      }
      this.#widths[name] = width;
      this.arrays[name] = new Float32Array(this.#pointCount * width);
    }
  }

  // Copies bytes, so that their alignment does not matter.
  #store(name, packed, begin, end) {
    const width = this.#widths[name] ?? 0;
    const target = this.arrays[name]?.subarray(begin * width, end * width) ?? new Uint8Array(0);
    if (packed.length !== target.byteLength) {
      throw new Error(`${name} of points from ${begin} has ${packed.length} bytes, not ${target.byteLength}`);
    }
    new Uint8Array(target.buffer, target.byteOffset, target.byteLength).set(packed);
  }

  // Checks that every point has its result. `summary` is the stream's Summary, or null if none came.
  finish(summary) {
    checkEnd(summary, this.#received, this.#pointCount);
  }
}

// The same checks, chunk by chunk, without a place for all results.
export class ChunkReader {
  #received = 0;
  #pointCount;
  #names;
  #widths = null;

  constructor(pointCount, names = null) {
    this.#pointCount = pointCount;
    this.#names = names;
  }

  get isComplete() {
    return this.#received === this.#pointCount;
  }

  // Returns { firstIndex, pointCount, status, ... } with arrays of the chunk's points. Throws as ResultCollector.add.
  read(chunk) {
    const { firstIndex, pointCount } = chunk;
    const end = checkPlace(chunk, this.#received, this.#pointCount);
    const collector = new ResultCollector(pointCount, this.#names);
    collector.add({ ...chunk, firstIndex: 0 });
    const widths = Object.entries(collector.arrays).map(([name, array]) => `${name} ${array.length / pointCount}`);
    this.#widths ??= widths.join();
    if (widths.join() !== this.#widths) {
      throw new Error(`points from ${firstIndex} have the arrays ${widths}, those before ${this.#widths}`);
    }
    this.#received = end;
    return { firstIndex, pointCount, ...collector.arrays };
  }

  // As ResultCollector.finish.
  finish(summary) {
    checkEnd(summary, this.#received, this.#pointCount);
  }
}

// Returns the index after the chunk's last point. Throws if the chunk does not follow those before.
function checkPlace({ firstIndex, pointCount }, received, cloudPoints) {
  const end = firstIndex + pointCount;
  if (firstIndex !== received || end === firstIndex) {
    throw new Error(`a result chunk of ${pointCount} points starts at ${firstIndex}, not ${received}`);
  }
  if (end > cloudPoints) throw new Error(`results up to point ${end} for a cloud of ${cloudPoints} points`);
  return end;
}

function checkEnd(summary, received, cloudPoints) {
  if (summary === null) throw new Error("the stream ended without a summary");
  if (summary.pointCount !== cloudPoints || received !== cloudPoints) {
    throw new Error(
      `${received} results and a summary of ${summary.pointCount} points for a cloud of ${cloudPoints} points`,
    );
  }
}
