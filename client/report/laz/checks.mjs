// Finds out that a file is damaged. LAZ has no checksums: a codec makes points of whatever bytes it gets.

const REMEDY = "the file is damaged, or its header is wrong";

/** Checks positions against the bounding box that the header tells, and keeps the least and largest of them. */
export class BoxCheck {
  constructor(layout) {
    this.layout = layout;
    this.low = [Infinity, Infinity, Infinity];
    this.high = [-Infinity, -Infinity, -Infinity];
  }

  /** Throws an Error that names the first of the points from `begin` to `end` that is outside. */
  check(records, begin, end) {
    const { recordBytes, axes } = this.layout;
    const view = new DataView(records.buffer, records.byteOffset, records.byteLength);
    for (let axis = 0; axis < 3; axis++) {
      const { scale, offset } = axes[axis];
      const [least, most] = this.#room(axis);
      for (let i = begin; i < end; i++) {
        const value = view.getInt32(i * recordBytes + 4 * axis, true) * scale + offset;
        if (value < least || value > most) this.#fail(i, axis, value);
        if (value < this.low[axis]) this.low[axis] = value;
        if (value > this.high[axis]) this.high[axis] = value;
      }
    }
  }

  // Boxes are written before or after coordinates are put on their lattice, so that one step of it, and rounding, is free.
  #room(axis) {
    const { low, high, axes } = this.layout;
    const slack = axes[axis].scale + 1e-12 * Math.max(Math.abs(low[axis]), Math.abs(high[axis]));
    return [low[axis] - slack, high[axis] + slack];
  }

  #fail(i, axis, value) {
    const { low, high } = this.layout;
    throw new Error(`point ${i} is outside of the bounding box that the header tells: ${"xyz"[axis]} is ${value}, ` +
      `expected ${low[axis]} to ${high[axis]}: ${REMEDY}`);
  }
}

const isFloat = (field) => field?.scaling === undefined && (field?.type === 9 || field?.type === 10);
// Rounding of float32, several times over.
const SUM_PRECISION = 1e-5;
const LENGTH_PRECISION = 1e-3;

/** Throws an Error that names the first point whose results contradict each other: H is the mean of k1 and k2 wherever
 * the status is ok, and directions are of length 1. `table` is a RecordTable, `statuses` null or those of its points. */
export function checkResults(table, statuses) {
  const isOk = (i) => statuses === null || statuses[i] === 1;
  const read = (names) => (names.every((name) => isFloat(table.field(name))) ? names.map((name) => table.values(name)) : null);
  const curvatures = read(["mean_curvature", "k1", "k2"]);
  for (let i = 0; curvatures && i < table.count; i++) {
    const [mean, k1, k2] = curvatures.map((values) => values[i]);
    const size = Math.abs(mean) + Math.abs(k1) + Math.abs(k2);
    if (!isOk(i) || Math.abs(k1 + k2 - 2 * mean) <= SUM_PRECISION * size || !Number.isFinite(size)) continue;
    throw new Error(`point ${i} contradicts itself: its mean curvature is ${mean}, its principal curvatures are ${k1} and ` +
      `${k2}, of which it is not the mean: the file is damaged, or was changed after curv wrote it`);
  }
  for (const d of ["d1", "d2"]) {
    const axes = read(["x", "y", "z"].map((axis) => d + axis));
    for (let i = 0; axes && i < table.count; i++) {
      const length = Math.hypot(axes[0][i], axes[1][i], axes[2][i]);
      if (!isOk(i) || Math.abs(length - 1) <= LENGTH_PRECISION || Number.isNaN(length)) continue;
      throw new Error(`point ${i} contradicts itself: its direction ${d} has the length ${length}, not 1: the file is ` +
        "damaged, or was changed after curv wrote it");
    }
  }
}
