// Turns a failed call into one exception with what a program and a person need to know.
import grpc from "@grpc/grpc-js";
import { decode } from "./protocol.mjs";

// A call failed; nothing of its result is valid.
//   code        grpc.status, a number; codeName its name, such as "INVALID_ARGUMENT"
//   details     what is wrong, for a person: names field, value and limit
//   reason      the cause for a program, such as "CHUNK_OUT_OF_ORDER"; "" where the server gave none
//   metadata    what the reason refers to, an object of strings
//   retryAfter  seconds after which the same call may succeed; null where waiting does not help
//   answered    whether a server took part in the call
//   transient   whether the same call may succeed on another try: waiting helps, or the server is or became unreachable
export class CurvdError extends Error {
  constructor(code, details, { reason = "", metadata = {}, retryAfter = null, transient = false, answered = true } = {}) {
    super(`${grpc.status[code]}: ${details}`);
    this.name = "CurvdError";
    this.code = code;
    this.codeName = grpc.status[code];
    this.details = details;
    this.reason = reason;
    this.metadata = metadata;
    this.retryAfter = retryAfter;
    this.transient = transient;
    this.answered = answered;
  }
}

// The CurvdError for a grpc.ServiceError; `answered` says whether a server is known to have taken part. Details that cannot
// be decoded are left out.
export function fromServiceError(error, answered) {
  const details = detailsOf(error);
  const transient = details.retryAfter !== undefined || serverIsGone(error.code, details.reason);
  return new CurvdError(error.code, error.details, { ...details, transient, answered: answered || Boolean(details.reason) });
}

// Proxies make UNKNOWN or INTERNAL of a server that died; curvd gives each of its own errors a reason.
function serverIsGone(code, reason) {
  if (code === grpc.status.UNKNOWN || code === grpc.status.INTERNAL) return !reason;
  return code === grpc.status.UNAVAILABLE;
}

function detailsOf(error) {
  const [packed] = error.metadata?.get("grpc-status-details-bin") ?? [];
  try {
    return packed ? decodeDetails(packed) : {};
  } catch {
    return {};
  }
}

function decodeDetails(packed) {
  const details = {};
  // The loader keeps the original name of this one field, because it brings google.protobuf.Any itself.
  for (const { type_url: typeUrl, value } of decode("google.rpc.Status", packed).details) {
    const name = typeUrl.slice(typeUrl.lastIndexOf("/") + 1);
    if (name === "google.rpc.ErrorInfo") {
      const { reason, metadata } = decode(name, value);
      Object.assign(details, { reason, metadata });
    } else if (name === "google.rpc.RetryInfo") {
      const { seconds = 0, nanos = 0 } = decode(name, value).retryDelay ?? {};
      details.retryAfter = seconds + nanos * 1e-9;
    }
  }
  return details;
}
