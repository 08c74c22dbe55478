// What messages show of the values that callers give.

const MOST_CHARACTERS = 100;
const MOST_DEPTH = 3;

// The value as a program has it, [0,0,NaN], with type and length before where it is a typed array, Float32Array(3) [0,0,1];
// of long ones the first 100 characters and "...".
export function show(value) {
  const text = textOf(value, 0);
  return text.length > MOST_CHARACTERS ? `${text.slice(0, MOST_CHARACTERS)}...` : text;
}

// What the value is, without what it holds: "an Array", "a number", "null".
export function kindOf(value) {
  if (value === null || value === undefined) return String(value);
  const name = typeof value === "object" ? classOf(value) || "object" : typeof value;
  return `${/^[aeio]/i.test(name) ? "an" : "a"} ${name}`;
}

export const isTypedArray = (value) => ArrayBuffer.isView(value) && !(value instanceof DataView);

// The name of an object's class; "" for plain ones.
function classOf(value) {
  const name = value.constructor?.name ?? "";
  return name === "Object" ? "" : String(name);
}

function textOf(value, depth) {
  if (typeof value === "string") return JSON.stringify(value.slice(0, MOST_CHARACTERS));
  if (typeof value === "bigint") return `${value}n`;
  if (typeof value === "function") return kindOf(value);
  if (typeof value !== "object" || value === null) return String(value);
  if (depth === MOST_DEPTH) return "...";
  if (Array.isArray(value)) return itemsOf(value, depth);
  if (isTypedArray(value)) return `${classOf(value)}(${value.length}) ${itemsOf(value, depth)}`;
  const fields = Object.entries(value).slice(0, MOST_CHARACTERS);
  const texts = fields.map(([name, field]) => `${textOf(name, depth)}:${textOf(field, depth + 1)}`);
  return `${classOf(value)} {${texts}}`.trimStart();
}

// Each item takes a character at least: no more than the first 100 are shown.
function itemsOf(array, depth) {
  return `[${Array.from(array.slice(0, MOST_CHARACTERS), (item) => textOf(item, depth + 1))}]`;
}
