// Chooses how a cloud stands, and from where it is seen. Its counterpart is client/render/pose.cc, whose header says how.

const DEGREE = Math.PI / 180;
const [LEAST_MEAN, OPEN_MEAN, ALONG_AXIS] = [0.1, 0.5, 0.9];
const [FLAT_RATIO, TALLER_RATIO, SEEN_RATIO] = [3, 1.1, 1.1];
const CELLS = 16;
const MIRRORED_SHARE = 0.5;
const USUAL = { azimuth: 35, elevation: 25 };
const AZIMUTH_STEP = 45;
const OPEN_ELEVATION = 45;

/** The points in a length unit of their own, and their unit normals, three arrays of coordinates each; a normal is zero
 * where there is none. */
function makeCloud(positions, normals) {
  const count = positions[0].length;
  const units = [0, 1, 2].map(() => new Float64Array(count));
  const mean = [0, 0, 0];
  let withNormal = 0;
  for (let i = 0; normals && i < count; i++) {
    const [x, y, z] = [normals[0][i], normals[1][i], normals[2][i]];
    const length = Math.sqrt(x * x + y * y + z * z);
    if (!Number.isFinite(length) || length === 0) continue;
    withNormal += 1;
    for (let axis = 0; axis < 3; axis++) {
      units[axis][i] = (1 / length) * normals[axis][i];
      mean[axis] += units[axis][i];
    }
  }
  const largest = positions.reduce((most, values) => values.reduce((size, c) => Math.max(size, Math.abs(c)), most), 0);
  // A power of two, so that no product of coordinates overflows or vanishes.
  const factor = largest > 0 ? 2 ** Math.min(-Math.floor(Math.log2(largest)), 1023) : 1;
  const scaled = positions.map((values) => values.map((c) => c * factor));
  const low = scaled.map((values) => values.reduce((least, c) => Math.min(least, c), Infinity));
  const high = scaled.map((values) => values.reduce((most, c) => Math.max(most, c), -Infinity));
  return {
    count,
    positions: scaled,
    normals: units,
    hasNormals: withNormal > 0,
    middle: low.map((c, axis) => 0.5 * (c + high[axis])),
    extent: low.map((c, axis) => high[axis] - c),
    mean: mean.map((c) => c / Math.max(1, withNormal)),
  };
}

/** Whether half of the cells that hold a point, or have one in their mirror image along the axis, do both. */
function isMirrored({ count, positions, middle, extent }, axis) {
  const seen = new Uint8Array(CELLS ** 3);
  const largest = Math.max(...extent);
  const cell = (offset) => Math.min(Math.max(Math.trunc((offset / largest + 0.5) * CELLS), 0), CELLS - 1);
  const mirror = [1, 1, 1].map((sign, a) => (a === axis ? -sign : sign));
  const offsets = [0, 0, 0];
  for (let i = 0; i < count; i++) {
    for (let a = 0; a < 3; a++) offsets[a] = positions[a][i] - middle[a];
    const [x, y, z] = offsets;
    seen[(cell(x) * CELLS + cell(y)) * CELLS + cell(z)] |= 1;
    seen[(cell(x * mirror[0]) * CELLS + cell(y * mirror[1])) * CELLS + cell(z * mirror[2])] |= 2;
  }
  const [both, any] = [seen.filter((sides) => sides === 3).length, seen.filter((sides) => sides !== 0).length];
  return both >= MIRRORED_SHARE * any;
}

function chooseUp(cloud) {
  const { extent, mean, hasNormals } = cloud;
  const length = Math.hypot(...mean);
  if (length >= LEAST_MEAN && mean[2] >= ALONG_AXIS * length) return "z";
  if (length >= LEAST_MEAN && mean[1] >= ALONG_AXIS * length) return "y";
  if (!hasNormals && FLAT_RATIO * extent[2] <= Math.min(extent[0], extent[1])) return "z";
  if (!hasNormals && FLAT_RATIO * extent[1] <= Math.min(extent[0], extent[2])) return "y";
  const [y, z] = [isMirrored(cloud, 1), isMirrored(cloud, 2)];
  if (y !== z) return y ? "z" : "y";
  if (y) return "z";
  return extent[1] >= TALLER_RATIO * extent[2] ? "y" : "z";
}

/** Unit vectors to the right and up in the picture, and toward the viewer. */
function viewOf({ azimuth, elevation }, up) {
  const [ca, sa] = [Math.cos(azimuth * DEGREE), Math.sin(azimuth * DEGREE)];
  const [ce, se] = [Math.cos(elevation * DEGREE), Math.sin(elevation * DEGREE)];
  const view = [[ca, sa, 0], [se * -sa, se * ca, ce], [ce * sa, ce * -ca, se]];
  return up === "y" ? view.map(([x, y, z]) => [x, z, -y]) : view;
}

/** How many points are seen from outside: those that face the viewer with nothing before them. */
function countSeen({ count, positions: [xs, ys, zs], normals: [nx, ny, nz], middle, extent }, [right, up, toward]) {
  const side = Math.trunc(Math.min(Math.max(Math.sqrt(count) / 3, 4), 96));
  const reach = Math.hypot(...extent);
  const along = (axis, x, y, z) => x * axis[0] + y * axis[1] + z * axis[2];
  const at = (offset) => Math.min(side - 1, Math.trunc(Math.max(0, (offset / reach + 0.5) * side)));
  const front = new Float64Array(side * side).fill(-Infinity);
  const [cells, depths] = [new Uint32Array(count), new Float64Array(count)];
  for (let i = 0; i < count; i++) {
    const [x, y, z] = [xs[i] - middle[0], ys[i] - middle[1], zs[i] - middle[2]];
    const cell = at(along(right, x, y, z)) * side + at(along(up, x, y, z));
    cells[i] = cell;
    depths[i] = along(toward, x, y, z);
    if (depths[i] > front[cell]) front[cell] = depths[i];
  }
  const behind = (3 * reach) / side;
  let seen = 0;
  for (let i = 0; i < count; i++) {
    if (along(toward, nx[i], ny[i], nz[i]) > 0 && depths[i] >= front[cells[i]] - behind) seen += 1;
  }
  return seen;
}

/** Resolves to { up, azimuth, elevation }. `normals` are null where there are none; `wantedUp` null where the cloud is to
 * say it. */
export async function choosePose(positions, normals, wantedUp, pause) {
  const cloud = makeCloud(positions, normals);
  if (Math.max(...cloud.extent) === 0) return { up: wantedUp ?? "z", ...USUAL };
  const up = wantedUp ?? chooseUp(cloud);
  const isOpen = cloud.mean[up === "y" ? 1 : 2] >= OPEN_MEAN;
  const elevation = isOpen ? OPEN_ELEVATION : USUAL.elevation;
  let azimuth = USUAL.azimuth;
  let most = SEEN_RATIO * countSeen(cloud, viewOf({ azimuth, elevation }, up));
  for (let step = 1; step < 8; step++) {
    await pause();
    const other = (USUAL.azimuth + step * AZIMUTH_STEP) % 360;
    const seen = countSeen(cloud, viewOf({ azimuth: other, elevation }, up));
    if (seen > most) [most, azimuth] = [seen, other];
  }
  return { up, azimuth, elevation };
}
