// One try of a call: a cloud goes out in chunks, its curvature or normals come back.
import { once } from "node:events";
import grpc from "@grpc/grpc-js";
import { CurvdError, fromServiceError } from "./errors.mjs";
import { ResultCollector } from "./results.mjs";
import { CallersError } from "./retries.mjs";
import { Scales } from "./scales.mjs";

const CHUNK_BYTES = 1 << 20;

// Sends the cloud once. Resolves to its arrays and its summary.
//   request     { header, cloud: { positions, normals, viewpoints }, arrays: names of those that must come, or null,
//               onProgress: a function or undefined }
//   timeoutMs   undefined: no limit
//   signal      an AbortSignal or undefined
// Rejects with a CurvdError, whose `answered` says whether a server took part; with the signal's reason if that ended the
// call; or with a CallersError of what onProgress throws, or its promise rejects with.
export function callOnce(service, { header, cloud, arrays, onProgress }, { timeoutMs, signal, metadata }) {
  const deadline = timeoutMs === undefined ? Infinity : Date.now() + timeoutMs;
  const stream = service.estimateCurvature(metadata, { deadline });
  const { source } = header.normals;
  const makesNormals = source !== "NORMAL_SOURCE_GIVEN";
  const makeCollector = () => new ResultCollector(header.pointCount, arrays, makesNormals);
  const scales = new Scales(header.options?.neighborCounts ?? [], makeCollector);
  let summary = null;
  let answered = false;
  return new Promise((resolve, reject) => {
    const onAbort = () => {
      stream.cancel();
      reject(signal.reason);
    };
    signal?.addEventListener("abort", onAbort, { once: true });
    stream.once("status", () => signal?.removeEventListener("abort", onAbort));
    stream.once("metadata", () => (answered = true));
    const breach = (error) => {
      stream.cancel();
      reject(new CurvdError(grpc.status.INTERNAL, `the server broke the protocol: ${error.message}`));
    };
    const failOfCaller = (error) => {
      stream.cancel();
      reject(new CallersError(error));
    };
    stream.on("data", (response) => {
      try {
        const refusal = callRefusal(response, header);
        if (refusal !== undefined) {
          stream.cancel();
          reject(refusal);
        }
        if (response.message === "progress" && onProgress !== undefined) {
          reportProgress(onProgress, response.progress, header.pointCount, failOfCaller);
        }
        if (response.message === "result") scales.of(response.result).add(response.result);
        if (response.message === "summary") {
          summary = response.summary;
          if (onProgress !== undefined) reportEnd(onProgress, header.pointCount, failOfCaller);
        }
      } catch (error) {
        breach(error);
      }
    });
    stream.on("error", (error) => reject(fromServiceError(error, answered)));
    // The last messages may still be on their way to "data" when the status is known, and the other way round.
    Promise.all([once(stream, "end"), once(stream, "status")])
      .then(() => {
        scales.finish(summary);
        resolve({ ...scales.results, summary });
      })
      .catch(breach);
    sendCloud(stream, header, cloud).catch(reject);
  });
}

// The CurvdError of a server that does not know what the header asks for, by what it accepted; undefined where it does.
export function callRefusal({ message, accepted }, { normals: { source }, options }) {
  if (message !== "accepted") return undefined;
  const tooOld = (to) => new CurvdError(grpc.status.UNIMPLEMENTED, `the server is too old to ${to}`);
  if (source !== "NORMAL_SOURCE_GIVEN" && accepted.normals?.source !== source) return tooOld("make or orient normals");
  if (options?.neighborCounts?.length > 0 && String(accepted.options?.neighborCounts) !== String(options.neighborCounts)) {
    return tooOld("take several neighbor counts");
  }
  if (options?.automaticScale && !accepted.options?.automaticScale) return tooOld("choose a scale");
  return undefined;
}

// Tells onProgress; `fail` gets what it throws, or its promise rejects with, which is the caller's, and no breach of the protocol.
export function reportProgress(onProgress, { phase, pointsReceived, pointsEstimated }, pointCount, fail) {
  const name = String(phase).replace(/^PHASE_/, "").toLowerCase().replaceAll("_", " ");
  try {
    Promise.resolve(onProgress({ phase: name, pointsReceived, pointsEstimated, pointCount })).catch(fail);
  } catch (error) {
    fail(error);
  }
}

// The same of a call that has its last result.
export function reportEnd(onProgress, pointCount, fail) {
  const all = { phase: "PHASE_SENDING", pointsReceived: pointCount, pointsEstimated: pointCount };
  reportProgress(onProgress, all, pointCount, fail);
}

// Writes the cloud no faster than the server reads it, and half-closes. Stops quietly when the call has ended: its
// status tells why.
export async function sendCloud(stream, header, cloud) {
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
