// Color maps, computed from their definitions: diverging ones in Msh, polar CIELAB (Moreland 2009), sequential ones in
// Oklch (Ottosson 2020). Each takes t to sRGB, three numbers from 0 to 255.

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const mix = (a, b, t) => a + (b - a) * t;

function toByte(linear) {
  const c = clamp(linear, 0, 1);
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
}

function mshColor([magnitude, saturation, hue]) {
  const lightness = magnitude * Math.cos(saturation);
  const chroma = magnitude * Math.sin(saturation);
  const curve = (t) => (t > 6 / 29 ? t ** 3 : (108 / 841) * (t - 4 / 29));
  const level = (lightness + 16) / 116;
  const x = 0.95047 * curve(level + (chroma * Math.cos(hue)) / 500);
  const y = curve(level);
  const z = 1.08883 * curve(level - (chroma * Math.sin(hue)) / 200);
  return [
    toByte(3.2406 * x - 1.5372 * y - 0.4986 * z),
    toByte(-0.9689 * x + 1.8758 * y + 0.0415 * z),
    toByte(0.0557 * x - 0.204 * y + 1.057 * z),
  ];
}

/** From -1 over light grey at 0 to 1. The ends are magnitude, saturation, hue, and how far the grey's hue is turned. */
function diverging(low, high) {
  return (t) => {
    const [magnitude, saturation, hue, turn] = t < 0 ? low : high;
    const way = Math.abs(t);
    return mshColor([88 + way * (magnitude - 88), way * saturation, hue + (1 - way) * turn]);
  };
}

function oklchColor(lightness, chroma, hue) {
  const [a, b] = [chroma * Math.cos(hue), chroma * Math.sin(hue)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

/** From dark to light with even steps of lightness; colors outside sRGB lose chroma. t goes from -1 to 1. */
function sequential(chromaAt, hueAt) {
  return (t) => {
    const way = (t + 1) / 2;
    const lightness = mix(0.27, 0.93, way);
    let chroma = chromaAt(way);
    const hue = (hueAt(way) * Math.PI) / 180;
    const inside = (color) => color.every((c) => c >= -1e-4 && c <= 1.0001);
    while (chroma > 0 && !inside(oklchColor(lightness, chroma, hue))) chroma -= 0.004;
    return oklchColor(lightness, Math.max(chroma, 0), hue).map(toByte);
  };
}

/** All are safe for color-blind readers: two hues that stay apart, or lightness that tells the order. */
export const COLOR_MAPS = [
  { id: "blue-red", name: "Blue to red", diverges: true,
    color: diverging([80, 1.08, -1.1, -0.561], [80, 1.08, 0.5, 0.561]) },
  { id: "purple-orange", name: "Purple to orange", diverges: true,
    color: diverging([64.97, 0.899, -0.8, -0.9], [85, 0.95, 1.07, 0.4]) },
  { id: "violet-yellow", name: "Violet over green to yellow", diverges: false,
    color: sequential(() => 0.16, (way) => mix(305, 103, way)) },
  { id: "navy-yellow", name: "Navy over grey to yellow", diverges: false,
    color: sequential((way) => 0.02 + 0.13 * Math.abs(2 * way - 1), (way) => (way < 0.5 ? 262 : 98)) },
];

/** Grey, as in the pictures of `curv render`. */
export const NO_VALUE_COLOR = [115, 115, 115];

/** Colors of statuses: those of Okabe and Ito (2008), which color-blind readers tell apart; grey for `ok`. */
const STATUS_COLORS = [
  [80, 80, 80], [178, 186, 194], [230, 159, 0], [0, 158, 115], [213, 94, 0], [204, 121, 167], [86, 180, 233],
  [0, 114, 178], [240, 228, 66],
];
export const statusColor = (status) => STATUS_COLORS[status] ?? STATUS_COLORS[0];

/** How far along the map a value lies, from -1 to 1. Zero has the middle of a diverging map if it lies between. */
export function mapPlace(value, low, high, diverges) {
  if (diverges && low < 0 && high > 0) return clamp(value < 0 ? -value / low : value / high, -1, 1);
  return clamp((2 * (value - low)) / (high - low) - 1, -1, 1);
}

/** 256 colors, RGBA, evenly over the values from low to high. */
export function rampOf(map, low, high) {
  const ramp = new Uint8Array(1024);
  for (let i = 0; i < 256; i++) {
    const value = mix(low, high, (i + 0.5) / 256);
    ramp.set([...map.color(mapPlace(value, low, high, map.diverges)), 255], 4 * i);
  }
  return ramp;
}

export function statusRamp() {
  const ramp = new Uint8Array(1024);
  for (let status = 0; status < 256; status++) ramp.set([...statusColor(status), 255], 4 * status);
  return ramp;
}

export const css = ([r, g, b]) => `rgb(${r}, ${g}, ${b})`;
