// Chooses how large splats are. Its counterparts are client/render/framing.cc and client/neighbors/.
import { filled } from "./filled.mjs";

const RANK = 6;
const LARGEST_DISC = 4;
const LARGEST_SHARE = 1 / 6;
const LEAF = 10;
const BLOCK = 8192;

/** Points in the order of a balanced tree: the middle of each range splits it across its longest side. Its methods are not
 * private: for the browsers that pages are made for, private ones would become several calls each. */
class PointTree {
  constructor(xs, ys, zs) {
    Object.assign(this, { xs: xs.slice(), ys: ys.slice(), zs: zs.slice() });
    this.order = filled(Uint32Array, xs.length, (i) => i);
    this.axes = new Uint8Array(xs.length);
    this.found = new Float64Array(RANK);
    this.split(0, xs.length);
  }

  split(begin, end) {
    if (end - begin <= LEAF) return;
    const middle = (begin + end) >> 1;
    const sides = [this.xs, this.ys, this.zs].map((values) => sideOf(values, begin, end));
    const axis = sides.indexOf(Math.max(...sides));
    this.axes[middle] = axis;
    this.select(axis === 0 ? this.xs : axis === 1 ? this.ys : this.zs, begin, end - 1, middle);
    this.split(begin, middle);
    this.split(middle + 1, end);
  }

  /** Puts the point that belongs there, by these keys, to `place`, smaller ones before it, larger ones behind it. */
  select(keys, first, last, place) {
    let low = first, high = last;
    while (low < high) {
      const pivot = keys[(low + high) >> 1];
      let i = low, j = high;
      while (i <= j) {
        while (keys[i] < pivot) i++;
        while (keys[j] > pivot) j--;
        if (i <= j) this.swap(i++, j--);
      }
      if (place <= j) high = j;
      else if (place >= i) low = i;
      else return;
    }
  }

  swap(i, j) {
    const { xs, ys, zs, order } = this;
    const [x, y, z, index] = [xs[i], ys[i], zs[i], order[i]];
    xs[i] = xs[j];
    ys[i] = ys[j];
    zs[i] = zs[j];
    order[i] = order[j];
    xs[j] = x;
    ys[j] = y;
    zs[j] = z;
    order[j] = index;
  }

  /** The distance from the point at that place of the order to the sixth nearest other; to the farthest if there are
   * fewer, 0 if there is none. */
  spacing(place) {
    this.found.fill(Infinity);
    this.search(0, this.xs.length, place, this.xs[place], this.ys[place], this.zs[place]);
    const others = Math.min(RANK, this.xs.length - 1);
    return others === 0 ? 0 : Math.sqrt(this.found[others - 1]);
  }

  search(begin, end, self, x, y, z) {
    const { xs, ys, zs } = this;
    if (end - begin <= LEAF) {
      for (let i = begin; i < end; i++) if (i !== self) this.offer(x - xs[i], y - ys[i], z - zs[i]);
      return;
    }
    const middle = (begin + end) >> 1;
    const axis = this.axes[middle];
    const beyond = axis === 0 ? x - xs[middle] : axis === 1 ? y - ys[middle] : z - zs[middle];
    const isBefore = beyond < 0;
    if (isBefore) this.search(begin, middle, self, x, y, z);
    else this.search(middle + 1, end, self, x, y, z);
    if (beyond * beyond > this.found[RANK - 1]) return;
    if (middle !== self) this.offer(x - xs[middle], y - ys[middle], z - zs[middle]);
    if (isBefore) this.search(middle + 1, end, self, x, y, z);
    else this.search(begin, middle, self, x, y, z);
  }

  offer(dx, dy, dz) {
    const { found } = this;
    const squared = dx * dx + dy * dy + dz * dz;
    if (squared >= found[RANK - 1]) return;
    let i = RANK - 1;
    for (; i > 0 && found[i - 1] > squared; i--) found[i] = found[i - 1];
    found[i] = squared;
  }
}

function sideOf(values, begin, end) {
  let low = Infinity, high = -Infinity;
  for (let i = begin; i < end; i++) {
    const value = values[i];
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return high - low;
}

async function spacings(positions, pause, tell) {
  const tree = new PointTree(...positions);
  const { length } = tree.order;
  const result = new Float64Array(length);
  for (let begin = 0; begin < length; begin += BLOCK) {
    const end = Math.min(begin + BLOCK, length);
    for (let i = begin; i < end; i++) result[tree.order[i]] = tree.spacing(i);
    await pause(() => tell(end / length));
  }
  return result;
}

/** Resolves to the radii with which splats at these positions, three arrays of coordinates, close the surface.
 * `tell(share)` is called with how much of it is done. */
export async function discRadii(positions, pause, tell) {
  let extent = 0;
  for (const values of positions) extent = Math.max(extent, sideOf(values, 0, values.length));
  if (extent === 0) return new Float64Array(positions[0].length).fill(1);
  const radii = await spacings(positions, pause, tell);
  const apart = radii.filter((spacing) => spacing > 0).sort();
  const usual = Math.min(apart.length > 0 ? apart[apart.length >> 1] : extent, LARGEST_SHARE * extent);
  return radii.map((radius) => (radius > 0 ? Math.min(radius, LARGEST_DISC * usual, LARGEST_SHARE * extent) : usual));
}
