// Writes numbers as people read them.

export const grouped = (count) => count.toLocaleString("en-US");

/** "1 point", "2,000 points". */
export const pointCount = (count) => `${grouped(count)} ${count === 1 ? "point" : "points"}`;

/** "1 point has", "2,000 points have". */
export const pointsHave = (count) => `${pointCount(count)} ${count === 1 ? "has" : "have"}`;

/** `digits` significant digits, as a power of ten where zeros would hide them. */
export function short(value, digits = 4) {
  if (Number.isNaN(value)) return "none";
  if (!Number.isFinite(value)) return value < 0 ? "−∞" : "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(digits - 1) : value.toPrecision(digits);
  return text.replace(/e([+-])(\d+)$/, (_, sign, power) => ` × 10${sign === "-" ? "⁻" : ""}${raised(power)}`)
    .replace("-", "−");
}

const raised = (digits) => [...digits].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]).join("");

/** With as many decimals as a step of `step` deserves. */
export function toStep(value, step) {
  if (!(step > 0)) return String(value);
  const decimals = Math.min(Math.max(Math.ceil(-Math.log10(step)), 0), 20);
  return (Math.abs(value) < 1e15 ? value.toFixed(decimals) : value.toExponential(8)).replace("-", "−");
}

/** Reads what `short` writes, and what people type. */
export function parse(text) {
  const plain = text.trim().replaceAll("−", "-").replace(",", ".")
    .replace(/\s*×\s*10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)$/, (_, power) =>
      `e${[...power].map((c) => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join("")}`);
  return plain === "" ? NaN : Number(plain);
}

/** What follows a value of the unit to a power: " 1/mm²". Without a known length unit, "1/length²". */
export function unitText(exponent, unit) {
  if (exponent === undefined || exponent === 0) return "";
  const size = Math.abs(exponent) > 1 ? raised(String(Math.abs(exponent))) : "";
  return exponent < 0 ? `1/${unit || "length"}${size}` : `${unit || "length"}${size}`;
}
