// Makes short codes of numbers and directions. Its counterpart is client/report/quantize.cc.
import { cross, firstTangent, octahedralDirection } from "../page/directions.mjs";

const LARGEST_HALF = 65504;
const SQUARE_STEPS = 127;
const ANGLE_STEPS = 255;
const NO_DIRECTION = -128;
const NO_ANGLE = 255;

const scalar = new Float64Array(1);
const halves = new Uint32Array(scalar.buffer);
// The least exponent e with |value| < 2^e; of subnormal numbers something far below any that counts here.
function exponentOf(value) {
  scalar[0] = value;
  return ((halves[1] >>> 20) & 2047) - 1022;
}

const TO_INTEGER = 2 ** 52;
/** Rounds a number from 0 to 2^51, ties to even. */
const roundToEven = (value) => value + TO_INTEGER - TO_INTEGER;

/** The bits of the binary16 number nearest to `value`, ties to even. */
export function halfBits(value) {
  if (Number.isNaN(value)) return 0x7e00;
  const sign = value < 0 || Object.is(value, -0) ? 0x8000 : 0;
  const size = Math.abs(value);
  if (size >= LARGEST_HALF + 16) return sign | 0x7c00;
  if (size === 0) return sign;
  const unit = Math.max(exponentOf(size) - 11, -24);
  return sign | (((unit + 24) << 10) + roundToEven(size * 2 ** -unit));
}

const dot = ([a, b, c], [x, y, z]) => a * x + b * y + c * z;

/** A vector of about unit length, without overflow; zero if it has no direction. */
function bounded(v) {
  const largest = Math.max(Math.abs(v[0]), Math.abs(v[1]), Math.abs(v[2]));
  if (!(largest > 0) || !Number.isFinite(v[0] + v[1] + v[2])) return [0, 0, 0];
  return v.map((c) => c / largest);
}

const signOf = (value) => (value < 0 ? -1 : 1);

/** Of the four codes around a direction, that whose direction is nearest. */
export function octahedralCode(direction) {
  const d = bounded(direction);
  const sum = Math.abs(d[0]) + Math.abs(d[1]) + Math.abs(d[2]);
  if (sum === 0) return [NO_DIRECTION, NO_DIRECTION];
  let [u, v] = [d[0] / sum, d[1] / sum];
  if (d[2] < 0) [u, v] = [(1 - Math.abs(v)) * signOf(u), (1 - Math.abs(u)) * signOf(v)];
  const length = Math.sqrt(dot(d, d));
  let [best, bestAgreement] = [[0, 0], -2];
  for (const along of [Math.floor(u * SQUARE_STEPS), Math.ceil(u * SQUARE_STEPS)]) {
    for (const across of [Math.floor(v * SQUARE_STEPS), Math.ceil(v * SQUARE_STEPS)]) {
      const agreement = dot(d, octahedralDirection(along, across)) / length;
      if (agreement > bestAgreement) [best, bestAgreement] = [[along, across], agreement];
    }
  }
  return best;
}

/** How far a direction is turned in the plane across a normal, from firstTangent on. */
export function angleCode(normal, direction) {
  const d = bounded(direction);
  const first = firstTangent(normal);
  const [along, across] = [dot(d, first), dot(d, cross(normal, first))];
  if (along === 0 && across === 0) return NO_ANGLE;
  return Math.round((Math.atan2(across, along) / Math.PI + 1) * ANGLE_STEPS) % ANGLE_STEPS;
}

/** Adds the arrays NAME_u and NAME_v of vectors, three arrays of coordinates, to `arrays`. `isKept(i)`: whether vector i
 * is one. Returns the codes' directions. */
export function addDirections(name, [xs, ys, zs], arrays, isKept = () => true) {
  const [us, vs] = [new Uint8Array(xs.length), new Uint8Array(xs.length)];
  for (let i = 0; i < xs.length; i++) {
    const [u, v] = octahedralCode(isKept(i) ? [xs[i], ys[i], zs[i]] : [0, 0, 0]);
    us[i] = u & 255;
    vs[i] = v & 255;
  }
  arrays[`${name}_u`] = us;
  arrays[`${name}_v`] = vs;
}

/** Adds the array of angles of `seconds` to the coded directions `first` of `arrays`. */
export function addAngles([xs, ys, zs], arrays) {
  const [us, vs] = ["first_u", "first_v"].map((name) => new Int8Array(arrays[name].buffer));
  arrays.angle = new Uint8Array(xs.length);
  for (let i = 0; i < xs.length; i++) {
    arrays.angle[i] = us[i] === NO_DIRECTION ? NO_ANGLE
      : angleCode(octahedralDirection(us[i], vs[i]), [xs[i], ys[i], zs[i]]);
  }
}
