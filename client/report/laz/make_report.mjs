// Makes the report of the records of a file. Its counterpart is client/report/report_page.cc: of the same points it makes
// the same codes, which the test of both compares.
import { indexHash } from "../page/report_file.mjs";
import { checkResults } from "./checks.mjs";
import { addAngles, addDirections, halfBits } from "./codes.mjs";
import { filled } from "./filled.mjs";
import { choosePose } from "./pose.mjs";
import { chooseColumns, describeQuantity } from "./quantities.mjs";
import { RecordTable } from "./record_table.mjs";
import { discRadii } from "./splats.mjs";

const LARGEST_PLACE = 65534;
const RADIUS_STEPS_AN_OCTAVE = 16;
const LARGEST_HASH = 0xffffffff;

/** The points that are held: all, or those with the smallest hashes, as ChoosePoints in client/report/thinning.cc. */
function choosePoints(size, most) {
  let limit = LARGEST_HASH;
  if (size > most) limit = filled(Uint32Array, size, indexHash).sort()[most - 1];
  const indices = new Uint32Array(Math.min(size, most));
  for (let i = 0, at = 0; i < size; i++) if (indexHash(i) <= limit) indices[at++] = i;
  return { limit, indices };
}

/** The values of the column `status`; null if there is none, or it is no column of whole numbers from 0 to 255. */
function statusesOf(table) {
  if (!table.has("status")) return null;
  const values = table.values("status");
  const isOne = (value) => Number.isInteger(value) && value >= 0 && value <= 255;
  return values.every(isOne) ? new Uint8Array(values) : null;
}

function countStatuses(statuses, words) {
  const counts = new Array(256).fill(0);
  for (const status of statuses ?? []) counts[status] += 1;
  return counts.map((count, value) => ({ value, word: words[value] ?? "unknown", count })).filter(({ count }) => count > 0);
}

const placeCodes = (values, low, high) => {
  const width = 0.5 * high - 0.5 * low;
  const share = (value) => (width > 0 ? Math.min(Math.max((0.5 * value - 0.5 * low) / width, 0), 1) : 0);
  return filled(Uint16Array, values.length, (i) => Math.round(share(values[i]) * LARGEST_PLACE));
};

/** Adds the array radius8 of splats that are rounded up, and resolves to the largest radius. */
async function addRadii(positions, { low, high }, arrays, pause, tell) {
  const half = Math.max(...low.map((least, axis) => 0.5 * high[axis] - 0.5 * least)) || 1;
  const places = positions.map((values, axis) => values.map((value) => (0.5 * value - 0.5 * low[axis]) / half));
  const radii = await discRadii(places, pause, tell);
  const largest = radii.reduce((most, radius) => Math.max(most, radius), 0);
  arrays.radius8 = filled(Uint8Array, radii.length, (i) =>
    Math.min(Math.floor(Math.log2(largest / radii[i]) * RADIUS_STEPS_AN_OCTAVE), 255));
  return largest;
}

function addOrientation(table, indices, statuses, arrays) {
  const [normals, first, second] = ["n", "d1", "d2"].map((prefix) => table.vectors(prefix, indices));
  if (normals) addDirections("normal", normals, arrays);
  else if (first && second) addDirections("normal", crossProducts(first, second), arrays);
  if (!first || !second) return;
  addDirections("first", first, arrays, (i) => !statuses || statuses[indices[i]] === 1);
  addAngles(second, arrays);
}

function crossProducts([ax, ay, az], [bx, by, bz]) {
  return [
    ax.map((_, i) => ay[i] * bz[i] - az[i] * by[i]),
    ax.map((_, i) => az[i] * bx[i] - ax[i] * bz[i]),
    ax.map((_, i) => ax[i] * by[i] - ay[i] * bx[i]),
  ];
}

function notesOf(table, { notes, laz: { withheldNote } }) {
  const withheld = table.values("withheld").filter((value) => value !== 0).length;
  return withheld > 0 ? [...notes, `${withheld}${withheldNote}`] : notes;
}

/** Resolves to { report, arrays, indices } of decompressed records. `written` is what curv wrote about the file, `box`
 * has the least and largest coordinates. */
export async function makeReport(written, records, box, tell, pause) {
  const { laz, ...report } = written;
  const table = new RecordTable(laz.layout, records, report.points);
  const statuses = statusesOf(table);
  checkResults(table, statuses);
  await pause(() => tell("Choosing colors …"));
  const { limit, indices } = choosePoints(report.points, laz.mostPoints);
  const most = Math.min(Math.max(Math.floor(laz.mostValues / indices.length), laz.fewestQuantities), laz.mostQuantities);
  const columns = chooseColumns(table, { ...laz, quantity: report.quantity }, most);

  const arrays = {};
  const positions = table.vectors("", indices);
  positions.forEach((values, a) => (arrays["xyz"[a]] = placeCodes(values, box.low[a], box.high[a])));
  const quantities = [];
  for (const column of columns.shown) {
    const { entry, values } = describeQuantity(table, column, statuses, indices, report.percents);
    arrays[`quantity${quantities.length}`] = filled(Uint16Array, indices.length, (i) => halfBits(values[i] / entry.scale));
    quantities.push(entry);
    await pause();
  }
  if (statuses) arrays.status = filled(Uint8Array, indices.length, (i) => statuses[indices[i]]);
  addOrientation(table, indices, statuses, arrays);
  await pause(() => tell("Choosing a view …"));
  const pose = await choosePose(positions, table.vectors("n", indices), report.up, pause);
  const largestRadius = await addRadii(positions, box, arrays, pause, (share) =>
    tell(`Measuring how large splats must be: ${Math.floor(100 * share)} % …`));
  Object.assign(report, {
    up: pose.up,
    pose: [pose.azimuth, pose.elevation],
    shown: indices.length,
    hashLimit: limit,
    unplaced: 0,
    low: box.low,
    high: box.high,
    statuses: countStatuses(statuses, laz.statusWords),
    quantities,
    leftOut: columns.leftOut,
    notes: notesOf(table, written),
    largestRadius,
  });
  return { report, arrays, indices };
}
