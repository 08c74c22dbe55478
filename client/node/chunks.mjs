// One try of a call whose results are handed on as they come.
import grpc from "@grpc/grpc-js";
import { callRefusal, reportEnd, reportProgress, sendCloud } from "./call.mjs";
import { CurvdError, fromServiceError } from "./errors.mjs";
import { ChunkReader } from "./results.mjs";
import { Scales } from "./scales.mjs";

// Sends the cloud once, as callOnce. Yields { firstIndex, pointCount, status, ... } with the arrays of some points, in the
// order of the points, with neighborCounts of each count after the other, and returns the summary. Nothing is read ahead of who iterates but what lies in buffers: gRPC's flow
// control then stops the server. Ending the iteration early cancels the call. Throws what callOnce rejects with, and what onProgress throws itself.
export async function* receiveChunks(service, { header, cloud, arrays, onProgress }, { timeoutMs, signal, metadata }) {
  const deadline = timeoutMs === undefined ? Infinity : Date.now() + timeoutMs;
  const stream = service.estimateCurvature(metadata, { deadline });
  const counts = header.options?.neighborCounts ?? [];
  const scales = new Scales(counts, () => new ChunkReader(header.pointCount, arrays));
  const read = (chunk) => {
    const results = scales.of(chunk).read(chunk);
    return counts.length === 0 ? results : { neighborCount: chunk.neighborCount, ...results };
  };
  const ended = new Promise((resolve) => stream.once("status", resolve));
  let answered = false;
  let summary = null;
  let callersError;
  const endWith = (error) => {
    callersError ??= { error };
    stream.cancel();
  };
  const onAbort = () => stream.cancel();
  signal.addEventListener("abort", onAbort, { once: true });
  stream.once("metadata", () => (answered = true));
  stream.on("error", () => {}); // one that comes while nobody iterates is told at the next step
  sendCloud(stream, header, cloud).catch(endWith);
  try {
    for await (const response of stream.iterator({ destroyOnReturn: false })) {
      const refusal = callRefusal(response, header);
      if (refusal !== undefined) throw refusal;
      if (response.message === "progress" && onProgress !== undefined) {
        reportProgress(onProgress, response.progress, header.pointCount, endWith);
      }
      if (response.message === "result") yield readOrBreach(() => read(response.result));
      if (response.message === "summary") {
        summary = response.summary;
        if (onProgress !== undefined) reportEnd(onProgress, header.pointCount, endWith);
      }
    }
    await ended;
    if (callersError !== undefined) throw callersError.error;
    readOrBreach(() => scales.finish(summary));
    return summary;
  } catch (error) {
    if (signal.aborted) throw signal.reason;
    if (callersError !== undefined) throw callersError.error;
    throw error instanceof CurvdError ? error : fromServiceError(error, answered);
  } finally {
    signal.removeEventListener("abort", onAbort);
    stream.cancel();
  }
}

function readOrBreach(read) {
  try {
    return read();
  } catch (error) {
    throw new CurvdError(grpc.status.INTERNAL, `the server broke the protocol: ${error.message}`);
  }
}
