// Takes an array of points out of the pieces in which it was received.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "proto/bulk_message.h"

namespace curvd {

// What is still to be taken of an array. Not thread-safe.
class PieceReader {
 public:
  // Room for a point of the largest type.
  using PointBytes = std::array<char, 3 * sizeof(double)>;

  // REQUIRES: `pieces` outlives the reader.
  explicit PieceReader(const curvature::wire::Pieces& pieces) : next_(pieces.begin()), end_(pieces.end()) {
    Advance(0);
  }
  // Bytes that lie together; 0 at the end.
  size_t together() const { return piece_.size(); }
  // REQUIRES: size <= together().
  std::string_view Take(size_t size) {
    const std::string_view taken = piece_.substr(0, size);
    Advance(size);
    return taken;
  }
  // Takes a point that may lie in several pieces, to `point`. REQUIRES: a whole point is left.
  std::string_view TakePoint(size_t point_bytes, PointBytes& point) {
    for (size_t filled = 0; filled < point_bytes;) {
      const std::string_view part = Take(std::min(point_bytes - filled, together()));
      filled += part.copy(point.data() + filled, part.size());
    }
    return {point.data(), point_bytes};
  }

 private:
  void Advance(size_t size) {
    piece_.remove_prefix(size);
    while (piece_.empty() && next_ != end_) piece_ = *next_++;
  }

  std::string_view piece_;
  curvature::wire::Pieces::const_iterator next_, end_;
};

}  // namespace curvd
