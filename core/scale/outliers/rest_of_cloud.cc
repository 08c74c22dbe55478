#include "core/scale/outliers/rest_of_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "core/base/page_array.h"
#include "core/cloud/lattice.h"

namespace curvd {
namespace {

constexpr float kNoCoordinate = std::numeric_limits<float>::quiet_NaN();

using Vectors = PageArray<std::array<float, 3>>;

absl::StatusOr<Vectors> MakeVectors(size_t size) {
  absl::StatusOr<Vectors> vectors = Vectors::Create(size);
  if (vectors.ok())
    std::fill_n(vectors->data(), size, std::array<float, 3>{kNoCoordinate, kNoCoordinate, kNoCoordinate});
  return vectors;
}

std::string_view BytesOf(const Vectors& vectors) {
  return {reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(std::array<float, 3>)};
}

}  // namespace

absl::StatusOr<Cloud> RestOfCloud(SpatialIndex index, size_t size, std::span<const int32_t> left_out,
                                  bool takes_normals) {
  auto positions = MakeVectors(size);
  if (!positions.ok()) return positions.status();
  auto normals = MakeVectors(takes_normals ? size : 0);
  if (!normals.ok()) return normals.status();
  const int exponent = -index.scale_exponent();
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const auto rank = static_cast<size_t>(points.id[i]);
      (*positions)[rank] = {std::ldexp(points.x[i], exponent), std::ldexp(points.y[i], exponent),
                            std::ldexp(points.z[i], exponent)};
      if (!takes_normals) continue;
      const SpatialIndex::LeafNormals& leaf_normals = index.normals(leaf);
      (*normals)[rank] = {leaf_normals.x[i], leaf_normals.y[i], leaf_normals.z[i]};
    }
  }
  for (const int32_t rank : left_out)
    (*positions)[static_cast<size_t>(rank)] = {kNoCoordinate, kNoCoordinate, kNoCoordinate};
  Lattice lattice;
  lattice.spacing = std::ldexp(index.lattice_spacing(), exponent);
  index = SpatialIndex();
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kSkip,
              takes_normals ? NormalsInput::kGiven : NormalsInput::kAbsent);
  cloud.Expect(size);
  if (lattice.spacing > 0.0) cloud.PlaceOn(lattice);
  absl::Status status = cloud.Append(BytesOf(*positions), BytesOf(*normals));
  if (status.ok()) status = cloud.Finish();
  if (!status.ok()) return status;
  return cloud;
}

}  // namespace curvd
