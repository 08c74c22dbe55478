// Collects the results of a call into typed arrays and checks that none is missing.

// What became of a point; the values of `status` in the result.
export const PointStatus = Object.freeze({
  OK: 1,
  TOO_FEW_NEIGHBORS: 2,
  DEGENERATE_AREA: 3,
  INVALID_INPUT: 4,
  INCONSISTENT_NORMALS: 5,
  SINGULAR_FIT: 6,
});

// Scalars a point in each array of a ResultChunk.
const WIDTHS = { meanCurvature: 1, gaussianCurvature: 1, k1: 1, k2: 1, d1: 3, d2: 3, radius: 1, status: 1 };

// Takes ResultChunks in order. Throws, saying what is wrong, if a server breaks the protocol.
export class ResultCollector {
  #received = 0;
  #pointCount;

  constructor(pointCount) {
    this.#pointCount = pointCount;
    this.arrays = {};
    for (const [name, width] of Object.entries(WIDTHS)) {
      this.arrays[name] =
        name === "status" ? new Uint8Array(pointCount) : new Float32Array(pointCount * width).fill(NaN);
    }
  }

  add(chunk) {
    const begin = chunk.firstIndex;
    const end = begin + chunk.pointCount;
    if (begin !== this.#received || end === begin) {
      throw new Error(`a result chunk of ${chunk.pointCount} points starts at ${begin}, not ${this.#received}`);
    }
    if (end > this.#pointCount) {
      throw new Error(`results up to point ${end} for a cloud of ${this.#pointCount} points`);
    }
    for (const [name, width] of Object.entries(WIDTHS)) {
      const packed = chunk[name];
      if (packed.length > 0 || name === "status") {
        this.#store(name, packed, begin * width, end * width);
      }
    }
    this.#received = end;
  }

  // Copies bytes, so that their alignment does not matter.
  #store(name, packed, begin, end) {
    const target = this.arrays[name].subarray(begin, end);
    if (packed.length !== target.byteLength) {
      throw new Error(`${name} of points from ${begin} has ${packed.length} bytes, not ${target.byteLength}`);
    }
    new Uint8Array(target.buffer, target.byteOffset, target.byteLength).set(packed);
  }

  // Checks that every point has its result. `summary` is the stream's Summary, or null if none came.
  finish(summary) {
    if (summary === null) throw new Error("the stream ended without a summary");
    if (summary.pointCount !== this.#pointCount || this.#received !== this.#pointCount) {
      throw new Error(
        `${this.#received} results and a summary of ${summary.pointCount} points ` +
          `for a cloud of ${this.#pointCount} points`,
      );
    }
  }
}
