// Estimates one tile so that every result is that of the whole cloud.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/tiles/points/halo.h"
#include "client/tiles/points/point_store.h"
#include "client/tiles/points/tile_cloud.h"
#include "client/tiles/tile_result.h"

namespace curv {

// What became of some points: a row for each, in their order.
struct TileAnswer {
  std::vector<Column> columns;
  // Of the neighborhoods. NaN where that is not known: then a radius is taken within which there are neighbors enough.
  std::vector<float> radii;
  // Which points are out of question whatever is around them; their radii do not count.
  std::vector<bool> is_unusable;
  bool has_opposed_normals = false;
  bool has_normals_off_surface = false;
};

// Estimates the points of a cloud and answers for those that `queries` tells. Called from several threads at once.
using TileEstimator =
    std::function<absl::StatusOr<TileAnswer>(const FloatArrays& cloud, const std::vector<uint32_t>& queries)>;

// DEFAULT of the width of halos, in radii of neighborhoods: hardly any point is then estimated twice.
inline constexpr double kHaloFactor = 1.25;

// Estimates a tile and writes its result. What its halo was too narrow for is estimated again with all points that its
// neighborhoods may hold. Errors are those of the estimator, of the store and of WriteTileResult; INTERNAL if
// neighborhoods turned out to be larger than they can be.
absl::StatusOr<TileResult> EstimateTile(const PointStore& store, size_t tile, double halo_factor,
                                        const TileEstimator& estimator);

}  // namespace curv
