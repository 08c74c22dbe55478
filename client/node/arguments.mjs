// Which options there are, and of which type. An option that nobody reads is an error: it would be ignored silently.
import { kindOf, show } from "./show.mjs";

const isCount = (value) => Number.isSafeInteger(value) && value >= 0;
const isNumber = (value) => typeof value === "number";
const isBoolean = (value) => typeof value === "boolean";
const isString = (value) => typeof value === "string";
const isFunction = (value) => typeof value === "function";
// Arrays and maps are none: nobody reads what they hold.
const isObject = (value) => typeof value === "object" && value !== null && value[Symbol.iterator] === undefined;
const isPath = (value) => isString(value) || value instanceof URL;
// Read by functions that say themselves what is wrong.
const anything = () => true;

// The contract counts in 32 bits, and protobuf would drop the others. Its 0 stands for a default, which callers get by giving none.
const isCount32 = (value) => isCount(value) && value > 0 && value < 2 ** 32;
const count = [isCount32, "a whole number from 1 to 4294967295"];
const seed = [isCount, "a whole number from 0 to 2^53 - 1"];
const number = [isNumber, "a number"];
const boolean = [isBoolean, "true or false"];
const string = [isString, "a string"];
const path = [isPath, "the path of a file"];
const readElsewhere = [anything, ""];

// Messages tell of a value what the third function says, if there is one, and show it otherwise. Tokens are not shown.
const SECURITY = {
  tls: boolean,
  caFile: path,
  certFile: path,
  keyFile: path,
  serverName: string,
  token: [isString, "a string", kindOf],
  sendTokenInPlainText: boolean,
};
const CONNECTION = {
  server: readElsewhere,
  security: [isObject, "an object, see connectionTo in security.mjs", kindOf],
  credentials: [isObject, "grpc.ChannelCredentials", kindOf],
};
const CALL = {
  timeoutMs: [(value) => isNumber(value) && value > 0, "a number of milliseconds above 0"],
  maxAttempts: [(value) => isCount(value) && value > 0, "a whole number from 1"],
  connectTimeoutMs: [(value) => isNumber(value) && value >= 0, "a number of milliseconds from 0"],
  signal: [(value) => value instanceof AbortSignal, "an AbortSignal"],
};
const CLOUD = {
  ...CALL,
  onProgress: [isFunction, "a function"],
  orientation: readElsewhere,
  viewpoint: readElsewhere,
  viewpoints: readElsewhere,
  direction: readElsewhere,
  skipInvalid: boolean,
  priority: readElsewhere,
  requestTag: string,
};
const CURVATURE = {
  ...CLOUD,
  estimator: readElsewhere,
  neighborCount: [(value) => isCount32(value) || isString(value), 'a whole number from 1 to 4294967295 or "auto"'],
  neighborCounts: readElsewhere,
  radius: number,
  neighborCountRange: readElsewhere,
  maxRadius: [(value) => isNumber(value) && value > 0, "a number above 0"],
  scalePerCloud: boolean,
  triangleCount: count,
  seed,
  rotationCount: count,
  jetDegree: count,
  regressionDegree: count,
  evenWeights: boolean,
  project: boolean,
  averageNormalWeight: number,
  normalMethod: readElsewhere,
  normalNeighborCount: count,
  normalRadius: number,
  quantities: readElsewhere,
  curvatureDirection: readElsewhere,
  curvatureDirections: readElsewhere,
  rejectOpposedNormals: boolean,
};
const NORMALS = { ...CLOUD, method: readElsewhere, neighborCount: count, radius: number };

// Each throws a TypeError that names the first option that does not exist, or is not of its type. An option that is
// undefined is one that is not given.
export function checkConnectionOptions(options) {
  check(options, CONNECTION, "a CurvatureClient");
  check(options.security ?? {}, SECURITY, "security");
}
export const checkCurvatureOptions = (options) => check(options, CURVATURE, "estimateCurvature");
export const checkNormalsOptions = (options) => check(options, NORMALS, "estimateNormals");
export const checkCallOptions = (options) => check(options, CALL, "this call");

// Splits the options of a function that makes its own client into those of the client and those of the call.
export function splitConnection(options) {
  if (!isObject(options)) return { connection: {}, call: options };
  const entries = Object.entries(options);
  const pick = (wanted) => Object.fromEntries(entries.filter(([name]) => Object.hasOwn(CONNECTION, name) === wanted));
  return { connection: pick(true), call: pick(false) };
}

function check(options, known, whose) {
  if (!isObject(options)) throw new TypeError(`options is ${show(options)}; it must be an object`);
  for (const [name, value] of Object.entries(options)) {
    if (!Object.hasOwn(known, name)) throw new TypeError(`${whose} has no option ${name}${hint(name, known)}`);
    const [isFine, wanted, tell = show] = known[name];
    if (value !== undefined && !isFine(value)) throw new TypeError(`${name} is ${tell(value)}; it must be ${wanted}`);
  }
}

function hint(name, known) {
  if (Object.hasOwn(CONNECTION, name)) return ": it is an option of the client";
  const near = Object.keys(known)
    .map((other) => ({ other, distance: editDistance(name.toLowerCase(), other.toLowerCase()) }))
    .sort((a, b) => a.distance - b.distance)[0];
  return near.distance <= Math.max(2, name.length / 3) ? `: did you mean ${near.other}?` : "";
}

// Letters to put in, take out or replace until one word is the other (Levenshtein).
function editDistance(a, b) {
  let row = Array.from({ length: b.length + 1 }, (_, j) => j);
  for (let i = 1; i <= a.length; ++i) {
    const next = [i];
    for (let j = 1; j <= b.length; ++j) {
      next.push(Math.min(row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1)));
    }
    row = next;
  }
  return row[b.length];
}
