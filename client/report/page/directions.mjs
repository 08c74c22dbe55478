// Takes the codes of directions apart. Its counterpart is client/report/quantize.cc.

/** As OctahedralDirection in client/report/quantize.cc. */
export function octahedralDirection(u, v) {
  const sign = (value) => (value < 0 ? -1 : 1);
  let [x, y] = [u / 127, v / 127];
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [(1 - Math.abs(y)) * sign(x), (1 - Math.abs(x)) * sign(y)];
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}

export const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

/** As FirstTangent in client/report/quantize.cc. */
export function firstTangent([x, y, z]) {
  const sign = z < 0 ? -1 : 1;
  const a = -1 / (sign + z);
  return [1 + sign * x * x * a, sign * x * y * a, -sign * x];
}
