// Reads the PNG files that a browser makes of itself: 8 bits a channel, RGB or RGBA, not interlaced.
import { inflateSync } from "node:zlib";

function paeth(a, b, c) {
  const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/** Width, height, and at(x, y), the red, green and blue of a pixel. */
export function readPng(bytes) {
  const data = [];
  let [width, height, channels] = [0, 0, 0];
  for (let at = 8; at < bytes.length; at += 12 + bytes.readUInt32BE(at)) {
    const kind = bytes.toString("latin1", at + 4, at + 8);
    const body = bytes.subarray(at + 8, at + 8 + bytes.readUInt32BE(at));
    if (kind === "IHDR") {
      [width, height, channels] = [body.readUInt32BE(0), body.readUInt32BE(4), { 2: 3, 6: 4 }[body[9]]];
      if (body[8] !== 8 || !channels || body[12] !== 0) throw new Error("a PNG of another kind");
    }
    if (kind === "IDAT") data.push(body);
  }
  const lines = inflateSync(Buffer.concat(data));
  const stride = width * channels;
  const pixels = Buffer.alloc(stride * height);
  for (let y = 0; y < height; y++) {
    const filter = lines[y * (stride + 1)];
    for (let i = 0; i < stride; i++) {
      const left = i >= channels ? pixels[y * stride + i - channels] : 0;
      const above = y > 0 ? pixels[(y - 1) * stride + i] : 0;
      const corner = i >= channels && y > 0 ? pixels[(y - 1) * stride + i - channels] : 0;
      const guess = [0, left, above, (left + above) >> 1, paeth(left, above, corner)][filter];
      pixels[y * stride + i] = lines[y * (stride + 1) + 1 + i] + guess;
    }
  }
  const at = (x, y) => [...pixels.subarray(y * stride + x * channels, y * stride + x * channels + 3)];
  return { width, height, at };
}

const differs = (a, b, by) => a.some((c, i) => Math.abs(c - b[i]) > by);

/** The share of pixels that differ between two pictures of one size. */
export function shareChanged(a, b) {
  let changed = 0;
  for (let y = 0; y < a.height; y++) {
    for (let x = 0; x < a.width; x++) changed += differs(a.at(x, y), b.at(x, y), 8) ? 1 : 0;
  }
  return changed / (a.width * a.height);
}

/** Of a convex body before an even background: how many pixels it covers, and how many show the background though the
 * body is seen on all four sides of them, in their row and in their column. */
export function countHoles(picture, background) {
  const { width, height } = picture;
  const rows = Array.from({ length: height }, () => [Infinity, -Infinity]);
  const columns = Array.from({ length: width }, () => [Infinity, -Infinity]);
  const empty = [];
  let covered = 0;
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      if (!differs(picture.at(x, y), background, 8)) {
        empty.push([x, y]);
        continue;
      }
      covered += 1;
      rows[y] = [Math.min(rows[y][0], x), x];
      columns[x] = [Math.min(columns[x][0], y), y];
    }
  }
  const isWithin = ([low, high], at) => low < at && at < high;
  return { covered, holes: empty.filter(([x, y]) => isWithin(rows[y], x) && isWithin(columns[x], y)).length };
}
