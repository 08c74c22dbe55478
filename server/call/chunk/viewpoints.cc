#include "server/call/chunk/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/call/chunk/piece_reader.h"

namespace curvd {

using curvature::wire::Pieces;

absl::Status Viewpoints::Append(const Pieces& pieces, ScalarType type) {
  const size_t point_bytes = 3 * ScalarBytes(type);
  const size_t size = size_ + curvature::wire::SizeOf(pieces) / point_bytes;
  if (absl::Status status = Reserve(size); !status.ok()) return status;
  PieceReader reader(pieces);
  PieceReader::PointBytes room;
  while (size_ < size) {
    const std::string_view bytes = reader.TakePoint(point_bytes, room);
    std::array<double, 3>& point = points_[size_++];
    if (type == ScalarType::kFloat64) {
      bytes.copy(reinterpret_cast<char*>(point.data()), point_bytes);
      continue;
    }
    std::array<float, 3> floats;
    bytes.copy(reinterpret_cast<char*>(floats.data()), point_bytes);
    std::copy(floats.begin(), floats.end(), point.begin());
  }
  return absl::OkStatus();
}

size_t Viewpoints::FiniteRun(size_t first, size_t most) const {
  const auto is_finite = [](const std::array<double, 3>& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  const auto begin = span().begin() + static_cast<ptrdiff_t>(first);
  const auto end = begin + static_cast<ptrdiff_t>(most);
  return static_cast<size_t>(std::find_if_not(begin, end, is_finite) - begin);
}

absl::Status Viewpoints::Reserve(size_t size) {
  if (size <= points_.size()) return absl::OkStatus();
  constexpr size_t kFirst = 65'536;
  const size_t capacity = expected_ > 0 ? std::max(expected_, size) : std::max({size, 2 * points_.size(), kFirst});
  auto grown = PageArray<std::array<double, 3>>::Create(capacity, expected_ > 0 ? PageUse::kWhole : PageUse::kSparse);
  if (!grown.ok()) return grown.status();
  std::copy(points_.data(), points_.data() + size_, grown->data());
  points_ = *std::move(grown);
  return absl::OkStatus();
}

}  // namespace curvd
