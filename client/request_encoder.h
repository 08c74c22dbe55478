// The messages of the request stream, as they go over the wire.
#pragma once

#include <cstddef>

#include "client/curvature_client.h"
#include "grpcpp/support/slice.h"

namespace curv {

// The first message: the options of the call.
grpc::Slice PackHeader(const CloudView& cloud, const EstimateOptions& options);

// Bytes that a point takes in all arrays of a chunk.
size_t BytesPerPoint(const CloudView& cloud);

// Points [first, first + count). REQUIRES: count > 0, first + count <= cloud.size().
grpc::Slice PackChunk(const CloudView& cloud, size_t first, size_t count);

}  // namespace curv
