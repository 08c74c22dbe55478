// Messages as gRPC receives them.
#pragma once

#include <algorithm>
#include <limits>
#include <string_view>
#include <vector>

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"

namespace curvd {

// `bytes` in pieces of `piece_bytes`, as a transport may have cut them.
inline grpc::ByteBuffer ToByteBuffer(std::string_view bytes, size_t piece_bytes = std::numeric_limits<size_t>::max()) {
  std::vector<grpc::Slice> pieces;
  while (!bytes.empty()) {
    const std::string_view piece = bytes.substr(0, piece_bytes);
    pieces.emplace_back(piece.data(), piece.size());
    bytes.remove_prefix(piece.size());
  }
  return {pieces.data(), pieces.size()};
}

}  // namespace curvd
