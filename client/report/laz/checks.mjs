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

// Rounding of float32, several times over.
const PRECISION = 2e-5;
const CHANGED = "the file is damaged, or was changed after curv wrote it";

/** Throws an Error that names the first point whose results contradict each other. Wherever the status is ok, and nowhere
 * else, there are curvatures, of which H is the mean of k1 and k2, and directions, which are unit vectors across each other;
 * normals are unit vectors if many are. `table` is a RecordTable, `statuses` null or those of its points. */
export function checkResults(table, statuses) {
  const isOk = (i) => statuses === null || statuses[i] === 1;
  const fail = (i, what) => {
    throw new Error(`point ${i} contradicts itself: ${what}: ${CHANGED}`);
  };
  checkCurvatures(table, statuses, isOk, fail);
  checkDirections(table, isOk, fail);
  checkNormals(table, fail);
}

const isFloat = (field) => field !== undefined && !field.scaling && (field.type === 9 || field.type === 10);
const floats = (table, names) => (names.every((name) => isFloat(table.field(name))) ? names.map((name) => table.values(name))
  : null);
const vectors = (table, prefix) => floats(table, ["x", "y", "z"].map((axis) => prefix + axis));

function checkCurvatures(table, statuses, isOk, fail) {
  const read = floats(table, ["mean_curvature", "k1", "k2"]);
  if (!read) return;
  const [means, firsts, seconds] = read;
  for (let i = 0; i < table.count; i++) {
    const [mean, k1, k2] = [means[i], firsts[i], seconds[i]];
    if (statuses && isOk(i) !== Number.isFinite(mean)) {
      fail(i, isOk(i) ? `its status is ok, but its mean curvature is ${mean}`
        : `its status is ${statuses[i]}, which is not ok, but it has the mean curvature ${mean}`);
    }
    const size = Math.abs(mean) + Math.abs(k1) + Math.abs(k2);
    if (Math.abs(k1 + k2 - 2 * mean) > PRECISION * size || k1 > k2) {
      fail(i, `its mean curvature is ${mean}, and its principal curvatures are ${k1} and ${k2}`);
    }
  }
}

function checkDirections(table, isOk, fail) {
  const [first, second] = ["d1", "d2"].map((prefix) => vectors(table, prefix));
  if (!first || !second) return;
  const dot = (i, a, b) => a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
  for (let i = 0; i < table.count; i++) {
    if (!isOk(i)) continue;
    for (const [d, direction] of [["d1", first], ["d2", second]]) {
      const squared = dot(i, direction, direction);
      if (!(Math.abs(squared - 1) <= PRECISION)) fail(i, `its direction ${d} has the length ${Math.sqrt(squared)}, not 1`);
    }
    const cosine = dot(i, first, second);
    if (Math.abs(cosine) > PRECISION) fail(i, `its directions are no right angle apart, the cosine is ${cosine}`);
  }
}

// Those of a file may have any length. Where one in ten has length 1, which damage does not make, the others shall, unless
// there is none.
function checkNormals(table, fail) {
  const normals = vectors(table, "n");
  if (!normals) return;
  const [xs, ys, zs] = normals;
  const squares = xs.map((x, i) => x * x + ys[i] * ys[i] + zs[i] * zs[i]);
  const isUnit = (squared) => Math.abs(squared - 1) <= PRECISION;
  if (10 * squares.reduce((count, squared) => count + (isUnit(squared) ? 1 : 0), 0) < table.count) return;
  squares.forEach((squared, i) => {
    if (squared !== 0 && !Number.isNaN(squared) && !isUnit(squared)) {
      fail(i, `its normal has the length ${Math.sqrt(squared)}, and many others length 1`);
    }
  });
}
