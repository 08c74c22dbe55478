#include "core/scale/outliers/rest_of_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "core/cloud/lattice.h"

namespace curvd {
namespace {

constexpr float kNoCoordinate = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<float, 3> kNoVector = {kNoCoordinate, kNoCoordinate, kNoCoordinate};

std::string_view BytesOf(const std::array<float, 3>* vectors, size_t count) {
  return {reinterpret_cast<const char*>(vectors), count * sizeof(*vectors)};
}

}  // namespace

absl::Status RestOfCloud::Allocate() {
  auto positions = Vectors::Create(size_);
  if (!positions.ok()) return positions.status();
  auto normals = Vectors::Create(takes_normals_ ? size_ : 0);
  if (!normals.ok()) return normals.status();
  positions_ = *std::move(positions);
  normals_ = *std::move(normals);
  return absl::OkStatus();
}

void RestOfCloud::Clear(size_t first, size_t last) {
  std::fill(positions_.data() + first, positions_.data() + last, kNoVector);
  if (takes_normals_) std::fill(normals_.data() + first, normals_.data() + last, kNoVector);
}

void RestOfCloud::Place(size_t first, size_t last) {
  const int exponent = -index_.scale_exponent();
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index_.positions(leaf);
    for (int i = 0; i < index_.LeafPoints(leaf); ++i) {
      const auto rank = static_cast<size_t>(points.id[i]);
      positions_[rank] = {std::ldexp(points.x[i], exponent), std::ldexp(points.y[i], exponent),
                          std::ldexp(points.z[i], exponent)};
      if (!takes_normals_) continue;
      const SpatialIndex::LeafNormals& normals = index_.given_normals(leaf);
      normals_[rank] = {normals.x[i], normals.y[i], normals.z[i]};
    }
  }
}

void RestOfCloud::LeaveOut(std::span<const int32_t> ranks) {
  for (const int32_t rank : ranks) positions_[static_cast<size_t>(rank)] = kNoVector;
}

void RestOfCloud::StartCloud() {
  cloud_ = Cloud(ScalarType::kFloat32, InvalidPointPolicy::kSkip,
                 takes_normals_ ? NormalsInput::kGiven : NormalsInput::kAbsent);
  cloud_.Expect(size_);
  Lattice lattice;
  lattice.spacing = std::ldexp(index_.lattice_spacing(), -index_.scale_exponent());
  if (lattice.spacing > 0.0) cloud_.PlaceOn(lattice);
}

absl::Status RestOfCloud::Append(size_t block) {
  const size_t first = block * Cloud::kBlockPoints, count = std::min(Cloud::kBlockPoints, size_ - first);
  const absl::Status status = cloud_.Append(BytesOf(positions_.data() + first, count),
                                            takes_normals_ ? BytesOf(normals_.data() + first, count) : "");
  if (!status.ok() || block + 1 < block_count()) return status;
  positions_ = Vectors();
  normals_ = Vectors();
  return cloud_.Finish();
}

}  // namespace curvd
