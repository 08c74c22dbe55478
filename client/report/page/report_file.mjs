// Unpacks what `curv report` wrote into the page. Its counterpart is client/report/report_page.cc.
import { bytesOfBase64, inflate } from "./bytes.mjs";
import { cross, firstTangent, octahedralDirection } from "./directions.mjs";

const LARGEST_PLACE = 65534;
const NO_DIRECTION = -128;
const NO_ANGLE = 255;
const ANGLE_STEPS = 255;

/** The value of each of the 65,536 binary16 numbers. */
function halfValues() {
  const values = new Float64Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const [exponent, places] = [(bits >> 10) & 31, bits & 1023];
    let value = exponent === 0 ? places * 2 ** -24 : (1024 + places) * 2 ** (exponent - 25);
    if (exponent === 31) value = places === 0 ? Infinity : NaN;
    values[bits] = bits & 0x8000 ? -value : value;
  }
  return values;
}
export const HALF_VALUES = halfValues();

/** Scalars of two bytes are kept as all low bytes, then all high bytes. */
function joinBytes(bytes, at, count) {
  const scalars = new Uint16Array(count);
  for (let i = 0; i < count; i++) scalars[i] = bytes[at + i] | (bytes[at + count + i] << 8);
  return scalars;
}

/** As IndexHash in client/report/thinning.cc. */
export function indexHash(index) {
  let hash = Math.imul(index ^ (index >>> 16), 0x9e3779b1);
  hash = Math.imul(hash ^ (hash >>> 15), 0x85ebca6b);
  return (hash ^ (hash >>> 16)) >>> 0;
}

/** The indices in the file of the points that the report holds. */
function chosenIndices(report) {
  const indices = new Uint32Array(report.shown);
  for (let index = 0, at = 0; index < report.points; index++) {
    if (indexHash(index) <= report.hashLimit) indices[at++] = index;
  }
  return indices;
}

/** The points of a report. They are counted as the report holds them; `indices` says which of the file's they are. */
export class Points {
  /** `arrays` and `indices` have room for all points of the report, of which the first `count` are there. */
  constructor(report, arrays, indices, count) {
    Object.assign(this, { report, arrays, indices, count });
    this.signed = Object.fromEntries(["normal_u", "normal_v", "first_u", "first_v"].filter((name) => arrays[name])
      .map((name) => [name, new Int8Array(arrays[name].buffer, arrays[name].byteOffset, arrays[name].length)]));
    this.sides = report.low.map((low, axis) => report.high[axis] / 2 - low / 2).map((half) => half * 2);
    const longest = Math.max(...report.low.map((low, axis) => report.high[axis] / 2 - low / 2));
    /** Sides of the bounding box, where the longest is 1. */
    this.extent = report.low.map((low, axis) => (longest > 0 ? (report.high[axis] / 2 - low / 2) / longest : 0));
    /** Length units of the file in one of the extent. */
    this.unit = longest > 0 ? longest * 2 : 1;
  }

  /** Whether the first points stand for all, wherever one stops. */
  get isShuffled() {
    return this.report.blocks !== undefined;
  }

  /** The point that has that index in the file; -1 if none that is here has. */
  find(index) {
    if (this.isShuffled) return this.indices.subarray(0, this.count).indexOf(index);
    let [low, high] = [0, this.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.indices[middle] < index) low = middle + 1;
      else high = middle;
    }
    return this.indices[low] === index ? low : -1;
  }

  isSomewhere(i) {
    return this.arrays.x[i] <= LARGEST_PLACE;
  }

  /** The position in the file's coordinates; each is within 1/131,068 of the box's side. */
  position(i) {
    return ["x", "y", "z"].map(
      (name, axis) => this.report.low[axis] + (this.arrays[name][i] / LARGEST_PLACE) * this.sides[axis],
    );
  }

  /** The position relative to the middle of the box, whose longest side is 1. */
  place(i) {
    return ["x", "y", "z"].map((name, axis) => (this.arrays[name][i] / LARGEST_PLACE - 0.5) * this.extent[axis]);
  }

  /** Places of up to 20,000 of the points that are here, evenly over them. */
  somePlaces() {
    const step = Math.max(Math.floor(this.count / 20_000), 1);
    const places = [];
    for (let i = 0; i < this.count; i += step) if (this.isSomewhere(i)) places.push(this.place(i));
    return places.length > 0 ? places : [[0, 0, 0]];
  }

  radius(i) {
    return this.report.largestRadius * 2 ** (-this.arrays.radius8[i] / 16);
  }

  /** The unit vector of the octahedral codes of that name; null for a point that has none. */
  #direction(name, i) {
    if (!this.arrays[`${name}_u`]) return null;
    const [u, v] = [this.signed[`${name}_u`][i], this.signed[`${name}_v`][i]];
    return u === NO_DIRECTION ? null : octahedralDirection(u, v);
  }

  normal(i) {
    return this.#direction("normal", i);
  }

  /** Both principal directions, as unit vectors; null for a point that has none. */
  directions(i) {
    const first = this.#direction("first", i);
    if (!first || this.arrays.angle[i] === NO_ANGLE) return null;
    const angle = (this.arrays.angle[i] / ANGLE_STEPS) * Math.PI;
    const side = firstTangent(first);
    const other = cross(first, side);
    return [first, side.map((c, axis) => Math.cos(angle) * c + Math.sin(angle) * other[axis])];
  }

  /** Value i of quantity q; NaN where there is none. */
  value(q, i) {
    return HALF_VALUES[this.arrays[`quantity${q}`][i]] * this.report.quantities[q].scale;
  }

  status(i) {
    return this.arrays.status ? this.arrays.status[i] : null;
  }
}

/** Reads the report that the page holds. */
export function readReport() {
  return JSON.parse(document.getElementById("report").textContent);
}

const bytesOfPoint = (report) => report.arrays.reduce((sum, { bytes }) => sum + bytes, 0);

/** The bytes that the page holds of the points; it forgets the text that they came in. */
export function takeBytes() {
  const element = document.getElementById("points");
  const bytes = bytesOfBase64(element.textContent);
  element.remove();
  return bytes;
}

/** Unpacks the points of the report. */
export async function readPoints(report) {
  const bytes = await inflate(takeBytes(), report.shown * bytesOfPoint(report));
  const arrays = {};
  let at = 0;
  for (const { name, bytes: width } of report.arrays) {
    arrays[name] = width === 2 ? joinBytes(bytes, at, report.shown) : bytes.subarray(at, at + report.shown);
    at += report.shown * width;
  }
  return new Points(report, arrays, chosenIndices(report), report.shown);
}

/** Returns a function that reads so many bytes of a stream. */
function takerOf(reader) {
  let [rest, at] = [new Uint8Array(0), 0];
  return async (size) => {
    const taken = new Uint8Array(size);
    for (let have = 0; have < size;) {
      if (at === rest.length) {
        const { value, done } = await reader.read();
        if (done) throw new Error("curv view ended before all of them had come");
        [rest, at] = [value, 0];
      }
      const piece = rest.subarray(at, at + Math.min(rest.length - at, size - have));
      taken.set(piece, have);
      at += piece.length;
      have += piece.length;
    }
    return taken;
  };
}

/** Receives the points of a report that `curv view` serves, block by block, and calls `arrived(points)` after each. */
export async function receivePoints(report, address, arrived) {
  const response = await fetch(address, { cache: "no-store" });
  if (!response.ok) throw new Error(`curv view answers ${response.status}`);
  const arrays = {};
  for (const { name, bytes } of report.arrays) {
    if (!name.startsWith("index_")) arrays[name] = new (bytes === 2 ? Uint16Array : Uint8Array)(report.shown);
  }
  const points = new Points(report, arrays, new Uint32Array(report.shown), 0);
  const take = takerOf(response.body.getReader());
  for (const count of report.blocks) {
    const bytes = await take(count * bytesOfPoint(report));
    let at = 0;
    for (const { name, bytes: width } of report.arrays) {
      const part = width === 2 ? joinBytes(bytes, at, count) : bytes.subarray(at, at + count);
      at += count * width;
      if (arrays[name]) arrays[name].set(part, points.count);
      else for (let i = 0; i < count; i++) points.indices[points.count + i] += part[i] * (name === "index_low" ? 1 : 65536);
    }
    points.count += count;
    arrived(points);
  }
}
