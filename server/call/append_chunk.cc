#include "server/call/append_chunk.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace curvd {
namespace {

using curvature::wire::Pieces;

constexpr size_t kMaxPointBytes = 3 * sizeof(double);

// The part of an array that is still to be taken.
class Rest {
 public:
  explicit Rest(const Pieces& pieces) : next_(pieces.begin()), end_(pieces.end()) { Advance(0); }
  // Bytes that lie together; 0 at the end.
  size_t together() const { return piece_.size(); }
  std::string_view Take(size_t size) {
    const std::string_view taken = piece_.substr(0, size);
    Advance(size);
    return taken;
  }
  // Takes a point that may lie in several pieces.
  std::string_view TakePoint(size_t point_bytes, std::array<char, kMaxPointBytes>& point) {
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
  Pieces::const_iterator next_, end_;
};

}  // namespace

absl::Status AppendPieces(const Pieces& positions, const Pieces& normals, ScalarType type, Cloud& cloud) {
  const size_t point_bytes = 3 * ScalarBytes(type);
  Rest position(positions), normal(normals);
  while (position.together() > 0) {
    const size_t together = std::min(position.together(), normal.together());
    const size_t whole = together - together % point_bytes;
    std::array<char, kMaxPointBytes> position_bytes, normal_bytes;
    absl::Status status = whole > 0 ? cloud.Append(position.Take(whole), normal.Take(whole))
                                    : cloud.Append(position.TakePoint(point_bytes, position_bytes),
                                                   normal.TakePoint(point_bytes, normal_bytes));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace curvd
