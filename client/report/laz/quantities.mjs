// Chooses the columns that a report shows, and sums each up. Its counterpart is client/report/report_quantity.cc.
import { filled } from "./filled.mjs";

const LARGEST = Number.MAX_VALUE;
const LARGEST_HALF = 65504;
const LEAST_NORMAL = 2 ** -1022;

/** Those that are shown, and the names of those that are left out. */
export function chooseColumns(table, { known, noQuantities, quantity }, most) {
  const known_ = new Set(known.map(({ column }) => column));
  const others = new Set(noQuantities);
  const candidates = known.filter(({ column }) => table.has(column));
  for (const column of table.names) if (!known_.has(column) && !others.has(column)) candidates.push({ column });
  const limit = Math.min(most, candidates.length);
  const wanted = candidates.findIndex(({ column }) => column === quantity);
  if (wanted >= limit) candidates.splice(limit - 1, 0, ...candidates.splice(wanted, 1));
  return { shown: candidates.slice(0, most), leftOut: candidates.slice(most).map(({ column }) => column) };
}

function sortedFinite(values) {
  const finite = new Float64Array(values.length);
  let count = 0;
  for (const value of values) if (value - value === 0) finite[count++] = value;
  return finite.subarray(0, count).sort();
}

const clampEnd = (value) => Math.min(Math.max(value, -0.25 * LARGEST), 0.25 * LARGEST);

/** Symmetric about zero, and wide enough for 98 % of the values, of which the largest stand at both ends. */
function symmetricEnds(sorted) {
  let [first, last] = [0, sorted.length - 1];
  for (let above = last - Math.floor(0.98 * last); above > 0; above--) {
    if (Math.abs(sorted[first]) > Math.abs(sorted[last])) first += 1;
    else last -= 1;
  }
  const size = Math.max(Math.abs(sorted[first]), Math.abs(sorted[last]));
  const end = size > 0 ? Math.min(size, 0.5 * LARGEST) : 1;
  return [-end, end];
}

/** Keeps low < high where all values are the same, or nearly. */
function widened([low, high]) {
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (high - low > 1e-6 * size) return [low, high];
  const by = size > 0 ? 0.5 * size : 1;
  return [low - by, high + by];
}

/** How a quantity with these values, of all points, is shown, without its scale. */
function sumUp(values, isSigned, percents) {
  const sorted = sortedFinite(values);
  const last = sorted.length - 1;
  const percentiles = percents.map((percent) => (last < 0 ? null : sorted[Math.round((percent / 100) * last)]));
  let ends = [-1, 1];
  if (last >= 0) {
    ends = isSigned ? symmetricEnds(sorted) : widened([clampEnd(percentiles[1]), clampEnd(percentiles[7])]);
  }
  return { finite: sorted.length, percentiles, low: ends[0], high: ends[1] };
}

/** The number that codes are multiplied with, so that the largest value is the largest code. */
function scaleOf(values) {
  let largest = 0;
  for (const value of values) {
    const size = Math.abs(value);
    if (size > largest && size < Infinity) largest = size;
  }
  const scale = largest / LARGEST_HALF;
  return scale >= LEAST_NORMAL && scale < Infinity ? scale : 1;
}

/** The entry of a report for a column, and its values at the chosen points. */
export function describeQuantity(table, column, statuses, chosen, percents) {
  const values = table.values(column.column);
  if (column.isCurvature && statuses) for (let i = 0; i < values.length; i++) if (statuses[i] !== 1) values[i] = NaN;
  const isFiniteOf = (holds) => values.some((value) => holds(value) && Number.isFinite(value));
  const isSigned = column.title ? column.signed : isFiniteOf((value) => value < 0) && isFiniteOf((value) => value > 0);
  const summary = sumUp(values, isSigned, percents);
  const ofChosen = filled(Float64Array, chosen.length, (i) => values[chosen[i]]);
  const entry = {
    column: column.column,
    title: column.title ?? column.column,
    signed: isSigned,
    finite: summary.finite,
    scale: scaleOf(ofChosen),
    low: summary.low,
    high: summary.high,
    percentiles: summary.percentiles,
  };
  if (column.title) entry.exponent = column.exponent;
  return { entry, values: ofChosen };
}
