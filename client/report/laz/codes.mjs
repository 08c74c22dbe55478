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

const signOf = (value) => (value < 0 ? -1 : 1);

/** The cosine between the direction of a code and the vector (x, y, z), times that vector's length. */
function agreement(u, v, x, y, z) {
  let [a, b] = [u / SQUARE_STEPS, v / SQUARE_STEPS];
  const c = 1 - Math.abs(a) - Math.abs(b);
  if (c < 0) [a, b] = [(1 - Math.abs(b)) * signOf(a), (1 - Math.abs(a)) * signOf(b)];
  return (x * a + y * b + z * c) / Math.sqrt(a * a + b * b + c * c);
}

/** Writes to us[i] and vs[i], as unsigned bits, that code of the four around a direction whose direction is nearest. */
function encodeDirection(x, y, z, us, vs, i) {
  const largest = Math.max(Math.abs(x), Math.abs(y), Math.abs(z));
  if (!(largest > 0) || !Number.isFinite(x + y + z)) {
    us[i] = vs[i] = NO_DIRECTION & 255;
    return;
  }
  // No sum of squares overflows.
  const [dx, dy, dz] = [x / largest, y / largest, z / largest];
  const sum = Math.abs(dx) + Math.abs(dy) + Math.abs(dz);
  let [u, v] = [dx / sum, dy / sum];
  if (dz < 0) [u, v] = [(1 - Math.abs(v)) * signOf(u), (1 - Math.abs(u)) * signOf(v)];
  const [along, across] = [Math.floor(u * SQUARE_STEPS), Math.floor(v * SQUARE_STEPS)];
  let best = -2 * sum;
  for (let way = 0; way < 4; way++) {
    const code = way < 2 ? along : Math.ceil(u * SQUARE_STEPS);
    const other = way % 2 === 0 ? across : Math.ceil(v * SQUARE_STEPS);
    const found = agreement(code, other, dx, dy, dz);
    if (found <= best) continue;
    best = found;
    us[i] = code & 255;
    vs[i] = other & 255;
  }
}

/** Adds the arrays NAME_u and NAME_v of vectors, three arrays of coordinates, to `arrays`. `isKept(i)`: whether vector i
 * is one. */
export function addDirections(name, [xs, ys, zs], arrays, isKept = () => true) {
  const [us, vs] = [new Uint8Array(xs.length), new Uint8Array(xs.length)];
  for (let i = 0; i < xs.length; i++) {
    if (isKept(i)) encodeDirection(xs[i], ys[i], zs[i], us, vs, i);
    else us[i] = vs[i] = NO_DIRECTION & 255;
  }
  arrays[`${name}_u`] = us;
  arrays[`${name}_v`] = vs;
}

const dot = ([a, b, c], [x, y, z]) => a * x + b * y + c * z;

/** How far a direction is turned in the plane across a normal, from firstTangent on. */
function angleCode(normal, direction) {
  if (!Number.isFinite(direction[0] + direction[1] + direction[2])) return NO_ANGLE;
  const first = firstTangent(normal);
  const [along, across] = [dot(direction, first), dot(direction, cross(normal, first))];
  if (along === 0 && across === 0) return NO_ANGLE;
  return Math.round((Math.atan2(across, along) / Math.PI + 1) * ANGLE_STEPS) % ANGLE_STEPS;
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
