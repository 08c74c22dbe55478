// Reads columns off decompressed records, by the layout that curv wrote. Its counterpart is client/io/las/las_columns.cc.

// Of the scalar types 1 to 10: bytes are read by the DataView's method of that name.
const READS = ["Uint8", "Int8", "Uint16", "Int16", "Uint32", "Int32", "BigUint64", "BigInt64", "Float32", "Float64"];
const FLOAT32 = 9;
const isWide = ({ type, scaling }) => (type === 7 || type === 8) && !scaling;
const LARGEST_EXACT = 2n ** 53n;

/** The records of a file as columns, which are read when they are asked for. */
export class RecordTable {
  constructor(layout, records, count) {
    this.layout = layout;
    this.count = count;
    this.view = new DataView(records.buffer, records.byteOffset, records.byteLength);
    this.columns = new Map();
    layout.axes.forEach((axis, a) => this.columns.set("xyz"[a], { type: 6, at: 4 * a, scaling: axis }));
    for (const field of layout.fields) this.#add(field);
  }

  // Integers of 64 bits that a double cannot hold are two columns.
  #add(field) {
    if (!isWide(field) || this.#isExact(field)) return this.columns.set(field.name, field);
    this.columns.set(`${field.name}_low`, { type: 5, at: field.at });
    this.columns.set(`${field.name}_high`, { type: 5, at: field.at + 4 });
  }

  #isExact({ type, at }) {
    const read = this.#reader(type);
    for (let i = 0; i < this.count; i++) {
      const value = read(i * this.layout.recordBytes + at);
      if (value > LARGEST_EXACT || value < -LARGEST_EXACT) return false;
    }
    return true;
  }

  #reader(type) {
    const { view } = this;
    const name = `get${READS[type - 1]}`;
    return (at) => view[name](at, true);
  }

  /** The names of the columns, in the order of a table of curv. */
  get names() {
    return [...this.columns.keys()];
  }

  has(name) {
    return this.columns.has(name);
  }

  field(name) {
    return this.columns.get(name);
  }

  /** The values of a column, as doubles: of all points, or of those with these indices. */
  values(name, indices = null) {
    const { type, at, bits, firstBit, scaling } = this.columns.get(name);
    const { recordBytes } = this.layout;
    const size = indices ? indices.length : this.count;
    const values = new Float64Array(size);
    if (type === FLOAT32) {
      // Most columns are of this type, and a call that is the same for all points takes a tenth of the time.
      const { view } = this;
      for (let i = 0; i < size; i++) values[i] = view.getFloat32((indices ? indices[i] : i) * recordBytes + at, true);
    } else {
      const read = this.#reader(type);
      for (let i = 0; i < size; i++) values[i] = Number(read((indices ? indices[i] : i) * recordBytes + at));
    }
    if (bits) for (let i = 0; i < size; i++) values[i] = (values[i] >> firstBit) & ((1 << bits) - 1);
    if (scaling) {
      const { scale, offset, noData } = scaling;
      for (let i = 0; i < size; i++) values[i] = values[i] === noData ? NaN : values[i] * scale + offset;
    }
    return values;
  }

  /** Three columns as vectors of the points with these indices; null if one is missing. */
  vectors(prefix, indices) {
    const names = ["x", "y", "z"].map((axis) => prefix + axis);
    return names.every((name) => this.has(name)) ? names.map((name) => this.values(name, indices)) : null;
  }
}
