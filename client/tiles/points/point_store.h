// The points of a plan, on disk.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_point.h"

namespace curv {

// Thread-safe.
class PointStore {
 public:
  // FAILED_PRECONDITION if the store cannot be read. REQUIRES: the plan outlives the store.
  static absl::StatusOr<PointStore> Open(const TilePlan& plan);

  const TilePlan& plan() const { return plan_; }
  // For each node of the plan's tree, about the radius that neighborhoods have there, times the reach of their
  // estimates: that of a disc with as many points, where the smallest part around that has twice as many were
  // everywhere as dense; with a radius, that one.
  const std::vector<double>& expected_radii() const { return expected_radii_; }

  // Appends the points `first` to `first + count` of the store.
  absl::Status Append(uint64_t first, uint64_t count, std::vector<TilePoint>& points) const;

 private:
  PointStore(const TilePlan& plan, InputFile file);
  void ExpectRadius(int32_t node, double radius);

  const TilePlan& plan_;
  InputFile file_;
  std::vector<double> expected_radii_;
};

}  // namespace curv
