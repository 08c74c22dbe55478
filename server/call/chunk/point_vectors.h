// A vector for each point of a cloud, as chunks bring them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/cloud.h"
#include "proto/bulk_message.h"
#include "server/call/chunk/piece_reader.h"

namespace curvd {

// Keeps them as `Scalar`, in one array. Not thread-safe; const methods are.
template <typename Scalar>
class PointVectors {
 public:
  using Vector = std::array<Scalar, 3>;
  // Bytes a point that this holds; at the peak, where nobody knows how many points will come, kGrowing times as many.
  static constexpr size_t kBytesPerPoint = sizeof(Vector);
  static constexpr size_t kGrowing = 3;

  // Says how many will come, so that one array of their size is made for them. REQUIRES: called before any is appended.
  void Expect(size_t points) { expected_ = points; }

  size_t size() const { return size_; }
  const Vector& operator[](size_t i) const { return vectors_[i]; }
  std::span<const Vector> span() const { return vectors_.span().first(size_); }

 protected:
  // Appends what `keep` makes of vectors of `type`, any values, as doubles. Errors: ErrorKind::kOutOfMemory.
  // REQUIRES: `pieces` hold whole points.
  template <typename Keep>
  absl::Status AppendKept(const curvature::wire::Pieces& pieces, ScalarType type, const Keep& keep) {
    const size_t point_bytes = 3 * ScalarBytes(type);
    const size_t size = size_ + curvature::wire::SizeOf(pieces) / point_bytes;
    if (absl::Status status = Reserve(size); !status.ok()) return status;
    PieceReader reader(pieces);
    PieceReader::PointBytes room;
    while (size_ < size) {
      const std::string_view bytes = reader.TakePoint(point_bytes, room);
      std::array<double, 3> vector;
      if (type == ScalarType::kFloat64) {
        bytes.copy(reinterpret_cast<char*>(vector.data()), point_bytes);
      } else {
        std::array<float, 3> floats;
        bytes.copy(reinterpret_cast<char*>(floats.data()), point_bytes);
        std::copy(floats.begin(), floats.end(), vector.begin());
      }
      vectors_[size_++] = keep(vector);
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Reserve(size_t size) {
    if (size <= vectors_.size()) return absl::OkStatus();
    constexpr size_t kFirst = 65'536;
    const size_t capacity = expected_ > 0 ? std::max(expected_, size) : std::max({size, 2 * vectors_.size(), kFirst});
    auto grown = PageArray<Vector>::Create(capacity, expected_ > 0 ? PageUse::kWhole : PageUse::kSparse);
    if (!grown.ok()) return grown.status();
    std::copy(vectors_.data(), vectors_.data() + size_, grown->data());
    vectors_ = *std::move(grown);
    return absl::OkStatus();
  }

  size_t expected_ = 0;
  size_t size_ = 0;
  PageArray<Vector> vectors_;
};

}  // namespace curvd
