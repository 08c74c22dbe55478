// Makes plain LAS of LAZ and COPC.
import { pointsOf, readHeader } from "./las.mjs";

// What tells how the points of a file are compressed, and no longer holds for another.
const OF_COMPRESSION = [
  ["laszip encoded", 22204],
  ["copc", 1],
  ["copc", 1000],
];
const tellsOfCompression = ({ user, id }) => OF_COMPRESSION.some(([its, itsId]) => its === user && itsId === id);

/** Resolves to the bytes of the LAS file that a LAZ or COPC file holds: the same header, records and points. Rejects with
 * an Error that says what is wrong, also for a file that is not compressed. */
export async function plainLas(bytes) {
  const header = readHeader(bytes);
  if (!header.isCompressed) throw new Error("the points are not compressed: it is a LAS file already");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const waveforms = header.minor >= 3 ? view.getBigUint64(227, true) : 0n;
  if (waveforms !== 0n) throw new Error("the file holds waveform packets, which curvd-las does not move");
  const kept = header.records.filter((record) => !tellsOfCompression(record));
  const before = kept.filter(({ isExtended }) => !isExtended);
  const behind = kept.filter(({ isExtended }) => isExtended);
  const points = await pointsOf(bytes, header);
  const bytesOf = ({ start, end }) => bytes.subarray(start, end);
  const parts = [bytes.slice(0, header.headerBytes), ...before.map(bytesOf), points, ...behind.map(bytesOf)];
  const pointsAt = header.headerBytes + before.reduce((sum, { start, end }) => sum + end - start, 0);

  const head = new DataView(parts[0].buffer);
  head.setUint32(96, pointsAt, true);
  head.setUint32(100, before.length, true);
  head.setUint8(104, header.format);
  if (header.minor >= 4) {
    head.setBigUint64(235, behind.length > 0 ? BigInt(pointsAt + points.length) : 0n, true);
    head.setUint32(243, behind.length, true);
  }
  return Buffer.concat(parts);
}
