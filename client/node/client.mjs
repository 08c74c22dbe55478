// Calls that try again, over connections that are kept.
import { setMaxListeners } from "node:events";
import { statSync } from "node:fs";
import { DEFAULT_SERVER, splitServers } from "./addresses.mjs";
import { checkCallOptions, checkConnectionOptions, checkCurvatureOptions, checkNormalsOptions, splitConnection } from "./arguments.mjs";
import { callOnce } from "./call.mjs";
import { fromServiceError } from "./errors.mjs";
import { commonHeader, curvatureHeader } from "./headers.mjs";
import { normalOptions } from "./normals.mjs";
import { CurvatureService, resultArrays } from "./protocol.mjs";
import { callWithRetries } from "./retries.mjs";
import { callMetadata, connectionTo } from "./security.mjs";

const CHANNEL_OPTIONS = {
  // A peer that died without a word is found in seconds.
  "grpc.keepalive_time_ms": 10_000,
  "grpc.keepalive_timeout_ms": 5_000,
  // One that came back is found by the next try.
  "grpc.initial_reconnect_backoff_ms": 250,
  "grpc.max_reconnect_backoff_ms": 2_000,
  "grpc.max_receive_message_length": 256 << 20,
  // A name with several addresses stands for replicas, which calls go to in turn.
  "grpc.service_config": JSON.stringify({ loadBalancingConfig: [{ round_robin: {} }] }),
};
const MOST_KEPT_CLIENTS = 16;

// Calls one server, or several replicas, over connections that it keeps until close. They do not keep a process alive.
export class CurvatureClient {
  #services;
  #metadata;
  #turn;
  #reached = false;
  #closing = new AbortController();

  // server, and of the options security and credentials: as estimateCurvature has them. Throws a TypeError if they make
  // no connection.
  constructor(server = DEFAULT_SERVER, options = {}) {
    checkConnectionOptions({ ...options, server });
    const targets = splitServers(server);
    this.#metadata = callMetadata(options.security);
    const connections = targets.map((target) => connectionTo(target, options.security));
    this.#services = targets.map((target, i) => {
      const credentials = options.credentials ?? connections[i].credentials;
      return new CurvatureService(target, credentials, { ...CHANNEL_OPTIONS, ...connections[i].options });
    });
    setMaxListeners(0, this.#closing.signal); // one for each call that runs
    this.#turn = Math.floor(Math.random() * targets.length);
  }

  // As the function estimateCurvature, without the options of connections.
  async estimateCurvature(positions, normals, options = {}) {
    checkCurvatureOptions(options);
    const normalsFrom = {
      ...options,
      method: options.normalMethod,
      neighborCount: options.normalNeighborCount,
      radius: options.normalRadius,
    };
    return this.#estimate(positions, normals, curvatureHeader(options), normalsFrom, options);
  }

  // As the function estimateNormals, without the options of connections.
  async estimateNormals(positions, normals = null, options = {}) {
    checkNormalsOptions(options);
    const asked = { ...options, quantities: ["normals", "normalQuality"] };
    return this.#estimate(positions, normals, commonHeader(asked), options, asked);
  }

  // Resolves to the contract's GetServerInfoResponse: what the server is and accepts. Options: timeoutMs, maxAttempts,
  // connectTimeoutMs and signal, as estimateCurvature has them. Rejects with a CurvdError.
  async info(options = {}) {
    checkCallOptions(options);
    return this.#withRetries(options, (service, timeoutMs, signal) => this.#ask(service, timeoutMs, signal));
  }

  // Ends the calls that run: they reject. Closes the connections. May be called again.
  close() {
    this.#closing.abort(new Error("the client is closed"));
    this.#services.forEach((service) => service.close());
  }

  async #estimate(positions, normals, header, normalsFrom, options) {
    const cloud = {
      positions,
      normals,
      viewpoints: options.viewpoints ?? null,
      curvatureDirections: options.curvatureDirections ?? null,
    };
    checkArrays(cloud);
    header.pointCount = cloud.positions.length / 3;
    header.scalarType = cloud.positions instanceof Float64Array ? "SCALAR_TYPE_FLOAT64" : "SCALAR_TYPE_FLOAT32";
    header.normals = normalOptions(cloud.normals !== null, normalsFrom);
    const request = { header, cloud, arrays: resultArrays(options.quantities), onProgress: options.onProgress };
    const estimate = await this.#withRetries(options, (service, timeoutMs, signal) =>
      callOnce(service, request, { timeoutMs, signal, metadata: this.#metadata }),
    );
    for (const { code, message } of estimate.summary.warnings) {
      process.emitWarning(message, { type: "CurvdWarning", code: `CURVD_${String(code).replace(/^WARNING_CODE_/, "")}` });
    }
    return estimate;
  }

  #ask(service, timeoutMs, signal) {
    const deadline = timeoutMs === undefined ? Infinity : Date.now() + timeoutMs;
    return new Promise((resolve, reject) => {
      let answered = false;
      const onAbort = () => {
        call.cancel();
        reject(signal.reason);
      };
      const call = service.getServerInfo({}, this.#metadata, { deadline }, (error, response) => {
        signal.removeEventListener("abort", onAbort);
        error === null ? resolve(response) : reject(fromServiceError(error, answered));
      });
      call.once("metadata", () => (answered = true));
      signal.addEventListener("abort", onAbort, { once: true });
    });
  }

  async #withRetries({ timeoutMs, maxAttempts = 6, connectTimeoutMs = 1500, signal }, attempt) {
    // AbortSignal.any came later than the oldest Node.js that is served.
    const stop = new AbortController();
    const sources = [this.#closing.signal, ...(signal === undefined ? [] : [signal])];
    const onAbort = (event) => stop.abort(event.target.reason);
    for (const source of sources) {
      if (source.aborted) throw source.reason;
      source.addEventListener("abort", onAbort, { once: true });
    }
    try {
      const result = await callWithRetries(
        this.#services,
        (service, timeLeft) => attempt(service, timeLeft, stop.signal),
        {
          first: this.#turn++,
          timeoutMs,
          maxAttempts,
          connectTimeoutMs: this.#reached ? undefined : connectTimeoutMs,
          signal: stop.signal,
        },
      );
      this.#reached = true;
      return result;
    } catch (error) {
      this.#reached ||= error?.answered === true;
      throw error;
    } finally {
      sources.forEach((source) => source.removeEventListener("abort", onAbort));
    }
  }
}

// Estimates the curvature at every point of a cloud.
//
// positions, normals: Float32Array or Float64Array of 3 N scalars, both of the same type; normals point outward, of any
// length above zero. Where normals is null, the server estimates and orients them, and the result has them as `normal`.
// Options:
//   server                HOST or HOST:PORT (50061), a gRPC target, or several with commas between: replicas, which calls
//                         go to in turn. Connections are kept from call to call. DEFAULT: "localhost:50061"
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
//                         "normalQuality" (normalResidual, normalVarianceRatio), "shapeIndex", "curvedness",
//                         "standardErrors" (meanCurvatureStandardError, k1StandardError, k2StandardError) with
//                         neighborCount "auto" or from 16 to 2,048 and an estimator that "auto" chooses among ("jet" with
//                         jetDegree 4), "chosenNeighborCount" and "estimatorWeights" (avgHexagramWeight,
//                         normalRegressionWeight, jetWeight) of "auto", "normalCurvature". DEFAULT, and []: the first five,
//                         DEFAULT_QUANTITIES, and "normals" unless they stay as they are given
//   curvatureDirection    of "normalCurvature": the direction in which it is wanted, [x, y, z]; it is projected on the tangent
//                         plane. NaN where nothing is left of it
//   curvatureDirections   instead: that of each point, an array as positions
//   skipInvalid           give an unusable point a status instead of failing the call. DEFAULT: false
//   rejectOpposedNormals  fail the call if normals point to opposite sides of one surface, instead of giving the points
//                         around such places a status, and warning. DEFAULT: false
//   priority              "interactive" if somebody waits, "batch" if it can wait. DEFAULT: interactive up to 100,000
//                         points, batch above
//   requestTag            free text for the server's log
//   timeoutMs             for the whole call with its retries. DEFAULT: no limit
//   maxAttempts           times the cloud is sent at most, while servers are unavailable or ask to wait: at once to the
//                         next replica, then with growing pauses. DEFAULT: 6, over about 8 seconds
//   connectTimeoutMs      after which a call gives up if no server has ever answered. DEFAULT: 1500
//   signal                an AbortSignal, which ends the call: it rejects with the signal's reason
//   onProgress            called with { phase, pointsReceived, pointsEstimated, pointCount } now and then; phase is "estimating"
//                         and the like. What it throws ends the call
//
// Resolves to { meanCurvature, gaussianCurvature, k1, k2, d1, d2, radius, status, summary }: Float32Arrays of N
// scalars (d1, d2: 3 N) and a Uint8Array of PointStatus; arrays of quantities that were not asked for are missing.
// Rejects with a CurvdError if the call fails, with a TypeError if the arguments make no request, such as an option
// that does not exist. What the server finds wrong with a cloud that it estimates nevertheless (summary.warnings) is
// emitted as a process warning of the type "CurvdWarning", whose code is "CURVD_" and the contract's word:
// "CURVD_OPPOSED_NORMALS".
export async function estimateCurvature(positions, normals, options = {}) {
  const { connection, call } = splitConnection(options);
  return withClient(connection, (client) => client.estimateCurvature(positions, normals, call));
}

// Estimates the normal at every point of a cloud; or turns those that are given, as orientation, viewpoint, viewpoints or
// direction says. The options `method`, `neighborCount` and `radius` are those that estimateCurvature has for normals; all
// others but those of estimators and quantities are as there.
//
// Resolves to { normal, normalResidual, normalVarianceRatio, status, summary }: unit normals, 3 N scalars; the other two are
// NaN for normals that were given; status says why there is no normal where it is not PointStatus.OK. summary.normals
// tells how they were made, and whether their sides can be trusted. Rejects and warns as estimateCurvature.
export async function estimateNormals(positions, normals = null, options = {}) {
  const { connection, call } = splitConnection(options);
  return withClient(connection, (client) => client.estimateNormals(positions, normals, call));
}

// Credentials of the caller's own cannot be compared with earlier ones: their client is closed after the call.
async function withClient({ server = DEFAULT_SERVER, security, credentials }, use) {
  if (credentials === undefined) return use(keptClient(server, security));
  const client = new CurvatureClient(server, { security, credentials });
  try {
    return await use(client);
  } finally {
    client.close();
  }
}

const keptClients = new Map();

// The client that earlier calls used; a new one where files of keys have changed. Those that were used last are kept; a
// call that runs keeps its own.
function keptClient(server, security) {
  const files = [security?.caFile, security?.certFile, security?.keyFile];
  const key = JSON.stringify([server, security, files.map(ageOf)]);
  const client = keptClients.get(key) ?? new CurvatureClient(server, { security });
  keptClients.delete(key);
  keptClients.set(key, client);
  if (keptClients.size > MOST_KEPT_CLIENTS) keptClients.delete(keptClients.keys().next().value);
  return client;
}

function ageOf(path) {
  return path === undefined ? null : (statSync(path, { throwIfNoEntry: false })?.mtimeMs ?? null);
}

function checkArrays({ positions, normals, viewpoints, curvatureDirections }) {
  const isFloats = positions instanceof Float32Array || positions instanceof Float64Array;
  const isAlike = (array) => array === null || array?.constructor === positions.constructor;
  if (!isFloats || !isAlike(normals)) {
    throw new TypeError(
      "positions and normals must both be Float32Array or both be Float64Array; to have normals estimated, give null",
    );
  }
  if (!isAlike(viewpoints)) throw new TypeError("viewpoints must be of the type of positions");
  if (!isAlike(curvatureDirections)) throw new TypeError("curvatureDirections must be of the type of positions");
  for (const [name, array] of Object.entries({ normals, viewpoints, curvatureDirections })) {
    const length = array?.length ?? positions.length;
    if (positions.length % 3 !== 0 || positions.length !== length) {
      throw new TypeError(`positions has ${positions.length} scalars and ${name} ${length}; both need 3 for each point`);
    }
  }
}
