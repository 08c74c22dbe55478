// One call: a cloud goes out in chunks, its curvature or normals come back.
import { once } from "node:events";
import grpc from "@grpc/grpc-js";
import { CurvdError, fromServiceError } from "./errors.mjs";
import { normalOptions } from "./normals.mjs";
import { CurvatureService, enumValues, QUANTITIES, resultArrays } from "./protocol.mjs";
import { ResultCollector } from "./results.mjs";
import { callWithRetries } from "./retries.mjs";
import { callMetadata, connectionTo } from "./security.mjs";

const CHUNK_BYTES = 1 << 20;
const CHANNEL_OPTIONS = {
  // A peer that died without a word is found in seconds.
  "grpc.keepalive_time_ms": 10_000,
  "grpc.keepalive_timeout_ms": 5_000,
  // One that came back is found by the next try.
  "grpc.initial_reconnect_backoff_ms": 250,
  "grpc.max_reconnect_backoff_ms": 2_000,
  "grpc.max_receive_message_length": 256 << 20,
};

// Two estimators have shorter names than the contract gives them.
const SHORT_NAMES = { "jet-fitting": "jet", "algebraic-shape-operator": "aso" };

// Every estimator by the name that people use: that of the contract without prefix, in small letters, - for _.
const ESTIMATORS = Object.fromEntries(
  enumValues("curvature.v1.Estimator")
    .filter((value) => value !== "ESTIMATOR_UNSPECIFIED")
    .map((value) => {
      const name = value.slice("ESTIMATOR_".length).toLowerCase().replaceAll("_", "-");
      return [SHORT_NAMES[name] ?? name, value];
    }),
);

const PRIORITIES = { interactive: "PRIORITY_INTERACTIVE", batch: "PRIORITY_BATCH" };

// Estimates the curvature at every point of a cloud.
//
// positions, normals: Float32Array or Float64Array of 3 N scalars, both of the same type; normals point outward, of any
// length above zero. Where normals is null, the server estimates and orients them, and the result has them as `normal`.
// Options:
//   server                HOST:PORT, or several with commas between: replicas, each call starting with any of them.
//                         DEFAULT: "localhost:50061"
//   security              TLS and token, see connectionTo in security.mjs. DEFAULT: plain text, no token
//   credentials           grpc.ChannelCredentials of your own instead of security's
//   estimator             "avg-hexagram" (DEFAULT), "hexagram", "uniform", "independent", "delaunay", "jet", "aso",
//                         "normal-regression", or "auto": what suits the cloud, averaged; summary.scale tells what was
//                         chosen, and why
//   neighborCount         the K nearest points, the point itself included; or "auto": as noise and detail ask for, at each
//                         point, for "auto" and the estimators that it chooses among. DEFAULT: 50, if there is no
//                         radius; with the estimator "auto", "auto"
//   radius                all points at most this far away, instead of neighborCount
//   neighborCountRange    of neighborCount "auto": [fewest, most] points. DEFAULT: [16, 2048], the widest there is, or up
//                         to what the server allows
//   maxRadius             of neighborCount "auto": how far an estimate looks at most. DEFAULT: any distance
//   scalePerCloud         of neighborCount "auto": the same choice for all points. DEFAULT: false
//   triangleCount, seed   of the random strategies. DEFAULT: 100 triangles, seed 0
//   rotationCount         hexagrams that avg-hexagram averages over, 1 to 4. DEFAULT: 2
//   jetDegree             of the polynomial that jet fits, 2 to 4; 4 for exact positions only. DEFAULT: 2; with neighborCount "auto"
//                         4, and no other
//   evenWeights           count all triangles of delaunay alike, as the paper does. DEFAULT: false
//   averageNormalWeight   share of the neighborhood's mean normal, in [0, 1]. DEFAULT: 0.5
//   orientation           which side is out: "consistent" (neighbors agree, closed pieces are seen from outside) or
//                         "closed" (the same for closed surfaces with holes). Normals that are given are then turned, as
//                         with the next three. DEFAULT: given normals stay; estimated ones are consistent
//   viewpoint             instead: where the surface was seen from, [x, y, z]
//   viewpoints            instead: where each point was seen from, an array as positions
//   direction             instead: no normal points against it, [x, y, z]
//   normalMethod          of estimated normals: "pca", "jet-1", "jet-2" or "jet-4". DEFAULT: as the points ask for
//   normalNeighborCount, normalRadius  of which points normals are estimated. DEFAULT: as their noise asks for
//   quantities            what the result shall have beside status, of "meanCurvature", "gaussianCurvature",
//                         "principalCurvatures" (k1, k2), "principalDirections" (d1, d2), "radius", "normals" (normal),
//                         "normalQuality" (normalResidual, normalVarianceRatio), "shapeIndex", "curvedness". DEFAULT, and
//                         []: all of curvature but the last two, and "normals" unless they stay as they are given
//   skipInvalid           give an unusable point a status instead of failing the call. DEFAULT: false
//   rejectOpposedNormals  fail the call if normals point to opposite sides of one surface, instead of giving the points
//                         around such places a status, and warning. DEFAULT: false
//   priority              "interactive" if somebody waits, "batch" if it can wait. DEFAULT: interactive up to 100,000
//                         points, batch above
//   requestTag            free text for the server's log
//   timeoutMs             for the whole call with its retries. DEFAULT: no limit
//   maxAttempts           times the cloud is sent at most, while servers are unavailable or ask to wait: at once to the
//                         next replica, then with growing pauses. DEFAULT: 6, over about 8 seconds
//
// Resolves to { meanCurvature, gaussianCurvature, k1, k2, d1, d2, radius, status, summary }: Float32Arrays of N scalars
// (d1, d2: 3 N) and a Uint8Array of PointStatus; arrays of quantities that were not asked for are missing. Rejects with a
// CurvdError if the call fails, with a TypeError if the arguments make no request. What the server finds wrong with a cloud
// that it estimates nevertheless (summary.warnings) is emitted as a process warning of the type "CurvdWarning", whose code
// is "CURVD_" and the contract's word: "CURVD_OPPOSED_NORMALS".
export async function estimateCurvature(positions, normals, options = {}) {
  const normalsFrom = {
    ...options,
    method: options.normalMethod,
    neighborCount: options.normalNeighborCount,
    radius: options.normalRadius,
  };
  return run({ positions, normals, viewpoints: options.viewpoints ?? null }, curvatureHeader(options), normalsFrom, options);
}

// Estimates the normal at every point of a cloud; or turns those that are given, as orientation, viewpoint, viewpoints or
// direction says. The options `method`, `neighborCount` and `radius` are those that estimateCurvature has for normals; all
// others but those of estimators and quantities are as there.
//
// Resolves to { normal, normalResidual, normalVarianceRatio, status, summary }: unit normals, 3 N scalars; the other two are
// NaN for normals that were given; status says why there is no normal where it is not PointStatus.OK. summary.normals
// tells how they were made, and whether their sides can be trusted. Rejects and warns as estimateCurvature.
export async function estimateNormals(positions, normals = null, options = {}) {
  const asked = { ...options, quantities: ["normals", "normalQuality"] };
  return run({ positions, normals, viewpoints: options.viewpoints ?? null }, commonHeader(asked), options, asked);
}

async function run(cloud, header, normalsFrom, options) {
  checkArrays(cloud);
  header.pointCount = cloud.positions.length / 3;
  header.scalarType = cloud.positions instanceof Float64Array ? "SCALAR_TYPE_FLOAT64" : "SCALAR_TYPE_FLOAT32";
  header.normals = normalOptions(cloud.normals !== null, normalsFrom);
  const arrays = resultArrays(options.quantities);
  const servers = (options.server ?? "localhost:50061").split(",").map((server) => server.trim());
  const connections = servers.map((server) => connectionTo(server, options.security));
  const clients = servers.map((server, i) => {
    const credentials = options.credentials ?? connections[i].credentials;
    return new CurvatureService(server, credentials, { ...CHANNEL_OPTIONS, ...connections[i].options });
  });
  const { timeoutMs, maxAttempts = 6 } = options;
  try {
    const attempt = (client, timeLeft) => call(client, header, cloud, arrays, timeLeft, callMetadata(options.security));
    const estimate = await callWithRetries(clients, attempt, { timeoutMs, maxAttempts });
    for (const { code, message } of estimate.summary.warnings) {
      process.emitWarning(message, { type: "CurvdWarning", code: `CURVD_${String(code).replace(/^WARNING_CODE_/, "")}` });
    }
    return estimate;
  } finally {
    clients.forEach((client) => client.close());
  }
}

function checkArrays({ positions, normals, viewpoints }) {
  const isFloats = positions instanceof Float32Array || positions instanceof Float64Array;
  const isAlike = (array) => array === null || array?.constructor === positions.constructor;
  if (!isFloats || !isAlike(normals)) {
    throw new TypeError(
      "positions and normals must both be Float32Array or both be Float64Array; to have normals estimated, give null",
    );
  }
  if (!isAlike(viewpoints)) throw new TypeError("viewpoints must be of the type of positions");
  for (const [name, array] of Object.entries({ normals, viewpoints })) {
    const length = array?.length ?? positions.length;
    if (positions.length % 3 !== 0 || positions.length !== length) {
      throw new TypeError(`positions has ${positions.length} scalars and ${name} ${length}; both need 3 for each point`);
    }
  }
}

function quantityNames(quantities = []) {
  const names = Array.isArray(quantities) ? quantities.map((name) => QUANTITIES.get(name)) : [undefined];
  if (names.includes(undefined) || new Set(names).size !== names.length) {
    const known = [...QUANTITIES.keys()].join(", ");
    throw new TypeError(
      `quantities is ${JSON.stringify(quantities)}; it must be an array that has each of ${known} at most once`,
    );
  }
  return names;
}

// The contract's AutomaticScale; undefined where the caller says how large neighborhoods are.
function scaleOf({ estimator, neighborCount, radius, neighborCountRange, maxRadius, scalePerCloud }) {
  if (radius !== undefined && (estimator === "auto" || neighborCount === "auto")) {
    throw new TypeError('radius does not go with "auto"; maxRadius says how far an estimate looks at most');
  }
  const leavesOpen = estimator === "auto" && neighborCount === undefined;
  if (neighborCount !== "auto" && !leavesOpen) {
    if (neighborCountRange !== undefined || maxRadius !== undefined || scalePerCloud) {
      throw new TypeError('neighborCountRange, maxRadius and scalePerCloud need neighborCount: "auto"');
    }
    return undefined;
  }
  const range = neighborCountRange ?? [0, 0];
  if (!Array.isArray(range) || range.length !== 2 || !range.every(Number.isInteger)) {
    throw new TypeError(
      `neighborCountRange is ${JSON.stringify(neighborCountRange)}; it must be [fewest, most] points, as [16, 2048]`,
    );
  }
  const [leastNeighborCount, mostNeighborCount] = range;
  return { leastNeighborCount, mostNeighborCount, maxRadius: maxRadius ?? 0, perCloud: scalePerCloud ?? false };
}

function curvatureHeader(options) {
  const { estimator = "avg-hexagram", neighborCount, radius } = options;
  if (!Object.hasOwn(ESTIMATORS, estimator)) {
    const names = Object.keys(ESTIMATORS).join(", ");
    throw new TypeError(`estimator is ${JSON.stringify(estimator)}; it must be one of ${names}`);
  }
  const automaticScale = scaleOf(options);
  if (neighborCount !== undefined && radius !== undefined) {
    throw new TypeError("neighborCount and radius exclude each other");
  }
  if (typeof neighborCount === "string" && neighborCount !== "auto") {
    throw new TypeError(`neighborCount is ${JSON.stringify(neighborCount)}; it must be a number or "auto"`);
  }
  return {
    ...commonHeader(options),
    options: {
      estimator: ESTIMATORS[estimator],
      ...(automaticScale !== undefined && { automaticScale }),
      ...(neighborCount !== undefined && neighborCount !== "auto" && { neighborCount }),
      ...(radius !== undefined && { radius }),
      triangleCount: options.triangleCount ?? 0,
      rotationCount: options.rotationCount ?? 0,
      jetDegree: options.jetDegree ?? 0,
      evenWeights: options.evenWeights ?? false,
      seed: options.seed ?? 0,
      ...(options.averageNormalWeight !== undefined && { averageNormalWeight: options.averageNormalWeight }),
    },
    opposedNormalsPolicy: options.rejectOpposedNormals ? "OPPOSED_NORMALS_POLICY_REJECT" : "OPPOSED_NORMALS_POLICY_MARK",
  };
}

// What curvature and normals are asked for with alike.
function commonHeader(options) {
  if (options.priority !== undefined && !Object.hasOwn(PRIORITIES, options.priority)) {
    throw new TypeError(`priority is ${JSON.stringify(options.priority)}; it must be interactive or batch`);
  }
  return {
    quantities: quantityNames(options.quantities),
    invalidPointPolicy: options.skipInvalid ? "INVALID_POINT_POLICY_SKIP" : "INVALID_POINT_POLICY_REJECT",
    priority: PRIORITIES[options.priority] ?? "PRIORITY_UNSPECIFIED",
    requestTag: options.requestTag ?? "",
  };
}

function call(client, header, cloud, arrays, timeoutMs, metadata) {
  const deadline = timeoutMs === undefined ? Infinity : Date.now() + timeoutMs;
  const stream = client.estimateCurvature(metadata, { deadline });
  const { source } = header.normals;
  const collector = new ResultCollector(header.pointCount, arrays, source !== "NORMAL_SOURCE_GIVEN");
  let summary = null;
  return new Promise((resolve, reject) => {
    const breach = (error) => {
      stream.cancel();
      reject(new CurvdError(grpc.status.INTERNAL, `the server broke the protocol: ${error.message}`));
    };
    stream.on("data", (response) => {
      try {
        if (response.message === "accepted" && source !== "NORMAL_SOURCE_GIVEN" && response.accepted.normals?.source !== source) {
          stream.cancel();
          reject(new CurvdError(grpc.status.UNIMPLEMENTED, "the server is too old to make or orient normals"));
        }
        if (response.message === "accepted" && header.options?.automaticScale && !response.accepted.options?.automaticScale) {
          stream.cancel();
          reject(new CurvdError(grpc.status.UNIMPLEMENTED, "the server is too old to choose a scale"));
        }
        if (response.message === "result") collector.add(response.result);
        if (response.message === "summary") summary = response.summary;
      } catch (error) {
        breach(error);
      }
    });
    stream.on("error", (error) => reject(fromServiceError(error)));
    // The last messages may still be on their way to "data" when the status is known, and the other way round.
    Promise.all([once(stream, "end"), once(stream, "status")])
      .then(() => {
        collector.finish(summary);
        resolve({ ...collector.arrays, summary });
      })
      .catch(breach);
    sendCloud(stream, header, cloud).catch(reject);
  });
}

// Writes the cloud no faster than the server reads it, and half-closes. Stops quietly when the call has ended: its
// status tells why.
async function sendCloud(stream, header, cloud) {
  const ended = new AbortController();
  stream.once("status", () => ended.abort());
  stream.write({ header });
  const arrays = Object.entries(cloud).filter(([, array]) => array !== null);
  const step = Math.floor(CHUNK_BYTES / (3 * arrays.length * cloud.positions.BYTES_PER_ELEMENT));
  for (let first = 0; first < header.pointCount && !ended.signal.aborted; first += step) {
    const chunk = { firstIndex: first };
    for (const [name, array] of arrays) chunk[name] = bytesOf(array, first, first + step);
    if (!stream.write({ chunk })) {
      await once(stream, "drain", { signal: ended.signal }).catch(() => {});
    }
  }
  stream.end();
}

function bytesOf(array, firstPoint, endPoint) {
  const part = array.subarray(3 * firstPoint, 3 * endPoint);
  return Buffer.from(part.buffer, part.byteOffset, part.byteLength);
}
