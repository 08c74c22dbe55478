// The range of the colors: a histogram with a handle at each end.
import { css, mapPlace } from "./color_maps.mjs";
import { parse, short } from "./numbers.mjs";
import { HALF_VALUES } from "./report_file.mjs";

const BINS = 80;
const KEY_SHARE = 0.02;

/** How often each binary16 number occurs in an array of them. */
function countCodes(codes) {
  const counts = new Uint32Array(65536);
  for (let i = 0; i < codes.length; i++) counts[codes[i]]++;
  return counts;
}

/** Counts of the values in even bins from low to high; `codes` are those of countCodes. */
export function binCounts(codes, scale, low, high) {
  const bins = new Float64Array(BINS);
  for (let code = 0; code < 65536; code++) {
    if (codes[code] === 0) continue;
    const at = (HALF_VALUES[code] * scale - low) / (high - low);
    if (at >= 0 && at <= 1) bins[Math.min(Math.floor(at * BINS), BINS - 1)] += codes[code];
  }
  return bins;
}

const find = (id) => document.getElementById(id);

export class RangeControl {
  /** Calls `changed(low, high)` after each change that a person makes. */
  constructor(changed) {
    this.changed = changed;
    for (const end of ["low", "high"]) this.#listenTo(end);
    find("robust").addEventListener("click", () => this.#reset(false));
    find("full").addEventListener("click", () => this.#reset(true));
    new ResizeObserver(() => this.#paint()).observe(find("histogram"));
  }

  /** Shows a quantity of the report, and its codes; the range is its robust one unless it was changed before. */
  setQuantity(quantity, codes) {
    this.quantity = quantity;
    this.counts = countCodes(codes);
    quantity.range ??= [quantity.low, quantity.high];
    quantity.isFull ??= false;
    this.#chooseDomain();
    this.#paint();
  }

  setMap(map) {
    this.map = map;
    this.#paint();
  }

  #reset(isFull) {
    const { quantity } = this;
    quantity.isFull = isFull;
    quantity.range = isFull ? this.#fullRange() : [quantity.low, quantity.high];
    this.#chooseDomain();
    this.#tell();
  }

  /** From the least to the largest value, symmetric about zero for a signed quantity. */
  #fullRange() {
    const { percentiles, low, high, signed } = this.quantity;
    const [least, largest] = [percentiles[0] ?? low, percentiles.at(-1) ?? high];
    if (!(largest > least)) return [low, high];
    const size = Math.max(Math.abs(least), Math.abs(largest));
    return signed ? [-size, size] : [least, largest];
  }

  /** What the histogram spans: half as much again as the range on each side, if there are values. */
  #chooseDomain() {
    const { range: [low, high], isFull, percentiles } = this.quantity;
    const width = high - low;
    const [least, largest] = [percentiles[0] ?? low, percentiles.at(-1) ?? high];
    this.domain = isFull ? [low, high]
      : [Math.min(low, Math.max(low - width / 2, least)), Math.max(high, Math.min(high + width / 2, largest))];
  }

  #listenTo(end) {
    const handle = find(`${end}-handle`);
    handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const box = find("histogram").getBoundingClientRect();
      const [from, to] = this.domain;
      this.#move(end, from + ((event.clientX - box.left) / box.width) * (to - from));
    });
    handle.addEventListener("keydown", ({ key }) => this.#pressKey(end, key));
    handle.addEventListener("keydown", (event) => event.key.startsWith("Arrow") && event.preventDefault());
    find(end).addEventListener("change", () => {
      const value = parse(find(end).value);
      if (Number.isFinite(value)) this.#move(end, value, true);
      else this.#paint();
    });
  }

  #pressKey(end, key) {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -5, PageUp: 5 }[key];
    if (!way) return;
    const [from, to] = this.domain;
    this.#move(end, this.quantity.range[end === "low" ? 0 : 1] + way * KEY_SHARE * (to - from));
  }

  /** Moves one end. Ends do not pass each other; typed ones may leave what the histogram spans. */
  #move(end, value, isTyped = false) {
    const [from, to] = this.domain;
    const least = (to - from) * 1e-3;
    let [low, high] = this.quantity.range;
    const kept = isTyped ? value : Math.min(Math.max(value, from), to);
    if (end === "low") low = isTyped && kept >= high ? low : Math.min(kept, high - (isTyped ? 0 : least));
    else high = isTyped && kept <= low ? high : Math.max(kept, low + (isTyped ? 0 : least));
    this.quantity.range = [low, high];
    if (isTyped) this.#chooseDomain();
    this.#tell();
  }

  #tell() {
    this.#paint();
    this.changed(...this.quantity.range);
  }

  #paint() {
    if (!this.quantity || !this.map) return;
    const [from, to] = this.domain;
    const range = this.quantity.range;
    for (const [i, end] of ["low", "high"].entries()) {
      const handle = find(`${end}-handle`);
      handle.style.left = `${Math.min(Math.max((range[i] - from) / (to - from), 0), 1) * 100}%`;
      handle.setAttribute("aria-valuemin", from);
      handle.setAttribute("aria-valuemax", to);
      handle.setAttribute("aria-valuenow", range[i]);
      handle.setAttribute("aria-valuetext", short(range[i]));
      find(end).value = short(range[i]);
    }
    const texts = [from, (from + to) / 2, to].map((value) => {
      const tick = document.createElement("span");
      tick.textContent = short(Math.abs(value) < (to - from) * 5e-4 ? 0 : value, 3);
      tick.style.left = `${((value - from) / (to - from)) * 100}%`;
      return tick;
    });
    find("ticks").replaceChildren(...texts);
    this.#paintBars(range);
  }

  #paintBars([low, high]) {
    const canvas = find("bars");
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
    if (width === 0) return;
    Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d");
    const [from, to] = this.domain;
    const bins = binCounts(this.counts, this.quantity.scale, from, to);
    const most = Math.max(...bins, 1);
    for (let bin = 0; bin < BINS; bin++) {
      const value = from + ((bin + 0.5) / BINS) * (to - from);
      const bar = bins[bin] > 0 ? Math.max((bins[bin] / most) * (height - 4), ratio) : 0;
      const [x, w] = [Math.floor((bin / BINS) * width), Math.ceil(width / BINS)];
      context.fillStyle = css(this.map.color(mapPlace(value, low, high, this.map.diverges)));
      context.fillRect(x, height - bar, w, bar);
      context.fillStyle = "rgba(110, 120, 130, 0.75)";
      context.fillRect(x, height - bar, w, Math.min(ratio, bar));
    }
  }
}
