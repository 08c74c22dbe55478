// Every ErrorInfo.reason that curvd sends; also the values of the label `reason` of curvd_failures_total.
#pragma once

namespace curvd {

// INVALID_ARGUMENT: the request is wrong.
inline constexpr char kReasonHeaderMissing[] = "HEADER_MISSING";
inline constexpr char kReasonHeaderRepeated[] = "HEADER_REPEATED";
inline constexpr char kReasonMessageEmpty[] = "MESSAGE_EMPTY";
inline constexpr char kReasonMessageMalformed[] = "MESSAGE_MALFORMED";
inline constexpr char kReasonInvalidOption[] = "INVALID_OPTION";
inline constexpr char kReasonChunkOutOfOrder[] = "CHUNK_OUT_OF_ORDER";
inline constexpr char kReasonChunkLength[] = "CHUNK_LENGTH";
inline constexpr char kReasonPointCountMismatch[] = "POINT_COUNT_MISMATCH";
inline constexpr char kReasonCloudIncomplete[] = "CLOUD_INCOMPLETE";
inline constexpr char kReasonInvalidPoint[] = "INVALID_POINT";
inline constexpr char kReasonOpposedNormals[] = "OPPOSED_NORMALS";

// UNAUTHENTICATED, PERMISSION_DENIED: the caller is not let in.
inline constexpr char kReasonTokenMissing[] = "TOKEN_MISSING";
inline constexpr char kReasonTokenInvalid[] = "TOKEN_INVALID";
inline constexpr char kReasonClientNotAllowed[] = "CLIENT_NOT_ALLOWED";

// RESOURCE_EXHAUSTED, and waiting does not help: over a limit that one call may reach.
inline constexpr char kReasonTooManyPoints[] = "TOO_MANY_POINTS";
inline constexpr char kReasonChunkTooLarge[] = "CHUNK_TOO_LARGE";
inline constexpr char kReasonNeighborhoodTooLarge[] = "NEIGHBORHOOD_TOO_LARGE";
inline constexpr char kReasonMemoryLimit[] = "MEMORY_LIMIT";

// RESOURCE_EXHAUSTED, and waiting helps: a limit that all calls share.
inline constexpr char kReasonStreamLimit[] = "STREAM_LIMIT";
inline constexpr char kReasonPeerStreamLimit[] = "PEER_STREAM_LIMIT";
inline constexpr char kReasonQueueFull[] = "QUEUE_FULL";
inline constexpr char kReasonMemoryBusy[] = "MEMORY_BUSY";
inline constexpr char kReasonOutOfMemory[] = "OUT_OF_MEMORY";

// UNAVAILABLE: try another replica.
inline constexpr char kReasonDraining[] = "DRAINING";
inline constexpr char kReasonDrainTimeout[] = "DRAIN_TIMEOUT";

// The caller's doing.
inline constexpr char kReasonCancelled[] = "CANCELLED";                 // CANCELLED
inline constexpr char kReasonDeadlineExceeded[] = "DEADLINE_EXCEEDED";  // DEADLINE_EXCEEDED
inline constexpr char kReasonStalled[] = "STALLED";                     // DEADLINE_EXCEEDED

// INTERNAL: a defect of the server.
inline constexpr char kReasonInternal[] = "INTERNAL";

// All of the above.
inline constexpr const char* kAllReasons[] = {
    kReasonHeaderMissing,    kReasonHeaderRepeated,     kReasonMessageEmpty,
    kReasonMessageMalformed, kReasonInvalidOption,      kReasonChunkOutOfOrder,
    kReasonChunkLength,      kReasonPointCountMismatch, kReasonCloudIncomplete,
    kReasonInvalidPoint,     kReasonOpposedNormals,     kReasonTokenMissing,
    kReasonTokenInvalid,     kReasonClientNotAllowed,   kReasonPeerStreamLimit,
    kReasonTooManyPoints,    kReasonChunkTooLarge,      kReasonNeighborhoodTooLarge,
    kReasonMemoryLimit,      kReasonStreamLimit,        kReasonQueueFull,
    kReasonMemoryBusy,       kReasonOutOfMemory,        kReasonDraining,
    kReasonDrainTimeout,     kReasonCancelled,          kReasonDeadlineExceeded,
    kReasonStalled,          kReasonInternal,
};

}  // namespace curvd
