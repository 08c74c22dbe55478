// Finds the point that one sees at a place of the picture.

/** The index, as the report counts, of the point at (x, y), in pixels from the middle, right and up; -1 for none. Of
 * the splats in front there, the one whose center is nearest. `isShown(i)` says which points are drawn. */
export function pickPoint(points, turntable, radiusFactor, isShown, x, y) {
  const scale = turntable.pixelsPerUnit();
  const { right, up, toward } = turntable.axes();
  const [r, u, t] = [right, up, toward].map((axis) => axis.toArray());
  const target = turntable.target.toArray();
  const { x: xs, y: ys, z: zs } = points.arrays;
  const [ex, ey, ez] = points.extent.map((side) => side / 65534);
  const base = points.extent.map((side, axis) => -side / 2 - target[axis]);
  const [atX, atY] = [x / scale, y / scale];
  const most = points.report.largestRadius * radiusFactor + 2 / scale;
  const near = [];
  for (let i = 0; i < points.count; i++) {
    if (xs[i] === 65535) continue;
    const [px, py, pz] = [xs[i] * ex + base[0], ys[i] * ey + base[1], zs[i] * ez + base[2]];
    const across = r[0] * px + r[1] * py + r[2] * pz - atX;
    if (across > most || across < -most) continue;
    const above = u[0] * px + u[1] * py + u[2] * pz - atY;
    if (above > most || above < -most) continue;
    const radius = Math.max(points.radius(i) * radiusFactor, 2 / scale);
    const distance = Math.hypot(across, above);
    if (distance > radius || !isShown(i)) continue;
    near.push({ i, distance, radius, depth: t[0] * px + t[1] * py + t[2] * pz });
  }
  if (near.length === 0) return -1;
  const front = near.reduce((best, one) => (one.depth > best.depth ? one : best));
  const seen = near.filter((one) => one.depth >= front.depth - 2 * Math.max(front.radius, one.radius));
  return seen.reduce((best, one) => (one.distance < best.distance ? one : best)).i;
}
