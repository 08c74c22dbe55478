// Reads LAS, LAZ and COPC files into the arrays that the functions of the client take.
import { readFile } from "node:fs/promises";
import { decompress } from "./laz.mjs";

// Bytes of a point of each format, 0 to 10, and of the header of LAS 1.0 to 1.4 (ASPRS LAS 1.4 R15).
const RECORD_BYTES = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
const HEADER_BYTES = [227, 227, 227, 235, 375];
const COMPRESSED = 0xc0;
// The most bytes of points that a byte of a compressed file may stand for; surveys have 5 to 20.
const MOST_INFLATION = 1024;
const RECORD_HEAD = 54;
const EXTENDED_HEAD = 60;
const DESCRIPTOR_BYTES = 192;
const NORMALS = [["normal_x", "NormalX", "nx"], ["normal_y", "NormalY", "ny"], ["normal_z", "NormalZ", "nz"]];
// Of the scalar types 1 to 10 of an extra attribute: bytes, and how a DataView reads one.
const SCALARS = [
  [1, (view, at) => view.getUint8(at)],
  [1, (view, at) => view.getInt8(at)],
  [2, (view, at) => view.getUint16(at, true)],
  [2, (view, at) => view.getInt16(at, true)],
  [4, (view, at) => view.getUint32(at, true)],
  [4, (view, at) => view.getInt32(at, true)],
  [8, (view, at) => Number(view.getBigUint64(at, true))],
  [8, (view, at) => Number(view.getBigInt64(at, true))],
  [4, (view, at) => view.getFloat32(at, true)],
  [8, (view, at) => view.getFloat64(at, true)],
];

// Reads a LAS, LAZ or COPC file: LAS 1.0 to 1.4, point formats 0 to 10. LAZ and COPC need the package laz-perf.
//   file  a path, or the bytes of a whole file as a Uint8Array
//
// Resolves to { positions, normals, pointCount }: positions is a Float64Array of 3 N scalars, raw * scale + offset; normals
// is one too, where the file has them as extra bytes (normal_x, NormalX or nx, and so on), and null elsewhere. Rejects with
// an Error that names the field, its value and what was expected if the file is anything else.
export async function readPointCloud(file) {
  const name = typeof file === "string" || file instanceof URL ? `${file}: ` : "";
  if (name === "" && !(file instanceof Uint8Array)) {
    throw new TypeError("file must be a path, or the bytes of a file as a Uint8Array");
  }
  const bytes = name === "" ? file : await readFile(file);
  try {
    const header = readHeader(bytes);
    return takeApart(header, await pointsOf(bytes, header));
  } catch (error) {
    throw new Error(`${name}${error.message}`, { cause: error });
  }
}

const viewOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
const textOf = (bytes) => new TextDecoder("latin1").decode(bytes).split("\0", 1)[0];

function check(holds, message) {
  if (!holds) throw new Error(message);
}

/** Reads and checks what stands around the points of a whole file. Throws an Error that says what is wrong. */
export function readHeader(bytes) {
  const view = viewOf(bytes);
  const signature = JSON.stringify(textOf(bytes.subarray(0, 4)));
  check(signature === '"LASF"', `the signature of the file is ${signature}: a LAS file starts with "LASF"`);
  check(bytes.length >= HEADER_BYTES[0], `the file ends after ${bytes.length} bytes: a LAS header has 227 or more`);
  const [major, minor] = [view.getUint8(24), view.getUint8(25)];
  check(major === 1 && minor <= 4, `the version is ${major}.${minor}: expected LAS 1.0 to 1.4`);
  const isCompressed = (view.getUint8(104) & COMPRESSED) !== 0;
  const format = view.getUint8(104) & ~COMPRESSED;
  check(format < RECORD_BYTES.length, `the point data record format is ${format}: expected 0 to 10`);
  check(!isCompressed || minor >= 2, `the version is 1.${minor}: laz-perf reads compressed points of LAS 1.2 to 1.4`);
  const headerBytes = view.getUint16(94, true);
  const [least, most] = [HEADER_BYTES[minor], bytes.length];
  check(headerBytes >= least && headerBytes <= most, `the header size is ${headerBytes}: expected ${least} to ${most}`);
  const pointsAt = view.getUint32(96, true);
  check(
    pointsAt >= headerBytes && pointsAt <= most,
    `the offset to point data is ${pointsAt}: expected ${headerBytes} to ${most}`,
  );
  const recordBytes = view.getUint16(105, true);
  check(
    recordBytes >= RECORD_BYTES[format],
    `the point data record length is ${recordBytes}: points of format ${format} take ${RECORD_BYTES[format]} or more`,
  );
  const header = { minor, format, isCompressed, headerBytes, pointsAt, recordBytes };
  header.pointCount = readCount(view, header);
  header.axes = [0, 1, 2].map((axis) => readAxis(view, axis));
  header.records = readRecords(bytes, header);
  header.descriptors = descriptorsOf(bytes, header.records);
  return header;
}

function readCount(view, { minor, isCompressed, pointsAt, recordBytes }) {
  const legacy = view.getUint32(107, true);
  let count = legacy;
  if (minor >= 4) {
    count = Number(view.getBigUint64(247, true)) || legacy;
    check(
      legacy === 0 || legacy === count,
      `the legacy number of point records is ${legacy}, the number of point records ${count}: expected 0 or the same`,
    );
  }
  const room = (view.byteLength - pointsAt) * (isCompressed ? MOST_INFLATION : 1);
  check(
    count * recordBytes <= room,
    `the file ends too early: the number of point records is ${count}, ${recordBytes} bytes each, but only ` +
      `${view.byteLength - pointsAt} bytes follow the offset to point data, ${pointsAt}`,
  );
  return count;
}

function readAxis(view, axis) {
  const [scale, offset] = [view.getFloat64(131 + 8 * axis, true), view.getFloat64(155 + 8 * axis, true)];
  const isFine = Number.isFinite(scale) && scale > 0;
  check(isFine, `the ${"XYZ"[axis]} scale factor is ${scale}: expected a finite number above 0`);
  check(Number.isFinite(offset), `the ${"XYZ"[axis]} offset is ${offset}: expected a finite number`);
  return { scale, offset };
}

// The variable length records, extended ones too: whose they are, which, and the bytes from `start` to `end`, of which
// the first `head` are the record's own header.
function readRecords(bytes, { minor, headerBytes, pointsAt }) {
  const view = viewOf(bytes);
  const records = [];
  const visit = (count, first, limit, isExtended) => {
    const head = isExtended ? EXTENDED_HEAD : RECORD_HEAD;
    let start = first;
    for (let i = 0; i < count; i++) {
      check(start + head <= limit, `variable length record ${i} starts at byte ${start}: its header ends behind ${limit}`);
      const length = isExtended ? Number(view.getBigUint64(start + 20, true)) : view.getUint16(start + 20, true);
      const end = start + head + length;
      check(end <= limit, `variable length record ${i} has ${length} bytes: they end behind byte ${limit}`);
      const user = textOf(bytes.subarray(start + 2, start + 18));
      records.push({ user, id: view.getUint16(start + 18, true), isExtended, start, head, end });
      start = end;
    }
  };
  visit(view.getUint32(100, true), headerBytes, pointsAt, false);
  if (minor >= 4) visit(view.getUint32(243, true), Number(view.getBigUint64(235, true)), bytes.length, true);
  return records;
}

// The descriptors of extra attributes, 192 bytes each.
function descriptorsOf(bytes, records) {
  return records
    .filter(({ user, id }) => user === "LASF_Spec" && id === 4)
    .flatMap(({ start, head, end }) =>
      Array.from({ length: Math.floor((end - start - head) / DESCRIPTOR_BYTES) }, (_, i) =>
        bytes.subarray(start + head + i * DESCRIPTOR_BYTES, start + head + (i + 1) * DESCRIPTOR_BYTES),
      ),
    );
}

/** Resolves to the points' records as they lie in an uncompressed file. */
export async function pointsOf(bytes, { isCompressed, pointsAt, pointCount, recordBytes }) {
  if (!isCompressed) return bytes.subarray(pointsAt, pointsAt + pointCount * recordBytes);
  return pointCount === 0 ? new Uint8Array() : decompress(bytes, pointCount, recordBytes);
}

// Where the attributes of a normal lie in a record, and how they are read; null where the file has none.
function normalFields({ format, recordBytes, descriptors }) {
  const fields = new Map();
  let at = RECORD_BYTES[format];
  for (const descriptor of descriptors) {
    const view = viewOf(descriptor);
    const [type, options] = [view.getUint8(2), view.getUint8(3)];
    const isScalar = type >= 1 && type <= SCALARS.length;
    const [width, read] = isScalar ? SCALARS[type - 1] : [0, null];
    const axis = NORMALS.findIndex((names) => names.includes(textOf(descriptor.subarray(4, 36))));
    if (isScalar && axis >= 0 && at + width <= recordBytes && !fields.has(axis)) {
      const scale = options & 8 ? view.getFloat64(112, true) : 1;
      const offset = options & 16 ? view.getFloat64(136, true) : 0;
      fields.set(axis, { at, valueAt: (records, place) => read(records, place) * scale + offset });
    }
    if (type > 30) break; // nobody knows how long it is
    // Type 0 is as many bytes as its options say; 11 to 30 are pairs and triples.
    at += type === 0 ? options : SCALARS[(type - 1) % 10][0] * (type <= 10 ? 1 : type <= 20 ? 2 : 3);
  }
  return fields.size === 3 ? [0, 1, 2].map((axis) => fields.get(axis)) : null;
}

function takeApart(header, records) {
  const { pointCount, recordBytes, axes } = header;
  const view = viewOf(records);
  const fields = normalFields(header);
  const positions = new Float64Array(3 * pointCount);
  const normals = fields && new Float64Array(3 * pointCount);
  for (let i = 0; i < pointCount; i++) {
    for (let axis = 0; axis < 3; axis++) {
      const { scale, offset } = axes[axis];
      positions[3 * i + axis] = view.getInt32(i * recordBytes + 4 * axis, true) * scale + offset;
      if (normals) normals[3 * i + axis] = fields[axis].valueAt(view, i * recordBytes + fields[axis].at);
    }
  }
  return { positions, normals, pointCount };
}
