// Functions that find their connection by themselves, and keep it from call to call.
import { statSync } from "node:fs";
import { DEFAULT_SERVER } from "./addresses.mjs";
import { checkConnectionOptions, splitConnection } from "./arguments.mjs";
import { CurvatureClient } from "./client.mjs";

const MOST_KEPT_CLIENTS = 16;

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
//   neighborCounts        instead, an array or a typed array of up to 16 numbers of neighbors in ascending order, with one search for the largest,
//                         for "avg-hexagram" and "normal-regression": the call resolves to { scales, summary }, and each of scales
//                         has neighborCount and the arrays, with the bytes of a call with that neighborCount alone
//   radius                all points at most this far away, instead of neighborCount
//   neighborCountRange    of neighborCount "auto": [fewest, most] points. DEFAULT: [16, 2048], the widest there is, or up
//                         to what the server allows
//   maxRadius             of neighborCount "auto": how far an estimate looks at most. DEFAULT: any distance
//   scalePerCloud         of neighborCount "auto": the same choice for all points. DEFAULT: false
//   triangleCount, seed   of the random strategies. DEFAULT: 100 triangles, seed 0
//   rotationCount         hexagrams that avg-hexagram averages over, 1 to 4. DEFAULT: 2
//   jetDegree             of the polynomial that jet fits, 2 to 4; 4 for exact positions only. DEFAULT: 2; with neighborCount "auto"
//                         4, and no other
//   regressionDegree      of the polynomials that normal-regression fits, 1 to 3: 3 follows the surface farther, 2 takes
//                         more of the noise away, and 1, fitted over space, is right for spheres, cylinders and planes at
//                         any size. DEFAULT: 3
//   project               estimate, by aso, the surface beside the point, not the level of the fitted field through it: for
//                         noisy positions. DEFAULT: false; with neighborCount "auto" always
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
//                         "standardErrors" (meanCurvatureStandardError, k1StandardError, k2StandardError) of "auto",
//                         "avg-hexagram", "normal-regression", "jet" of degree 4, and "aso" with project, with neighborCount
//                         "auto" or from 16 to 2,048, "chosenNeighborCount" and "estimatorWeights" (avgHexagramWeight,
//                         normalRegressionWeight, jetWeight, asoWeight) of "auto", "normalCurvature". DEFAULT, and []: the first five,
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
//   connectTimeoutMs      after which a call gives up if no server has ever answered and each was tried. DEFAULT: 1500
//   signal                an AbortSignal, which ends the call: it rejects with the signal's reason
//   onProgress            called with { phase, pointsReceived, pointsEstimated, pointCount } now and then; phase is "estimating"
//                         and the like. What it throws, or its promise rejects with while the try that told it runs,
//                         ends the call
//
// Resolves to { meanCurvature, gaussianCurvature, k1, k2, d1, d2, radius, status, summary }: Float32Arrays of N
// scalars (d1, d2: 3 N) and a Uint8Array of PointStatus; arrays of quantities that were not asked for are missing.
// Rejects with a CurvdError if the call fails, with a TypeError if the arguments make no request, such as an option
// that does not exist. What the server finds wrong with a cloud that it estimates nevertheless (summary.warnings) is
// emitted as a process warning of the type "CurvdWarning", whose code is "CURVD_" and the contract's word:
// "CURVD_OPPOSED_NORMALS", "CURVD_OUTLIERS" where points were left out, or "CURVD_NO_RESULTS" where no point has a result.
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
async function withClient(connection, use) {
  checkConnectionOptions(connection);
  const { server = DEFAULT_SERVER, security, credentials } = connection;
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
