#include "client/tiles/points/point_store.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace curv {
namespace {

// The area of a piece of surface that fills a box: that of its largest side.
double SurfaceIn(const Box& box) {
  std::array<double, 3> extents = {box.Extent(0), box.Extent(1), box.Extent(2)};
  std::sort(extents.begin(), extents.end());
  return extents[1] * extents[2];
}

}  // namespace

PointStore::PointStore(const TilePlan& plan, InputFile file) : plan_(plan), file_(std::move(file)) {
  const Box& box = plan.tree.root().box;
  expected_radii_.resize(plan.tree.nodes().size());
  ExpectRadius(0, plan.reach.Around(plan.reach.neighbor_count == 0 ? plan.reach.radius : box.FarDistanceTo(box.low)));
}

void PointStore::ExpectRadius(int32_t node, double radius) {
  const CellNode& at = plan_.tree.nodes()[static_cast<size_t>(node)];
  const uint64_t neighbors = plan_.reach.neighbor_count;
  if (neighbors > 0 && at.count >= 2 * neighbors) {
    const double share = static_cast<double>(neighbors) / static_cast<double>(at.count);
    radius = plan_.reach.Around(std::sqrt(share * SurfaceIn(at.box) / std::numbers::pi));
  }
  expected_radii_[static_cast<size_t>(node)] = radius;
  if (at.is_cell()) return;
  for (const int32_t child : at.children) ExpectRadius(child, radius);
}

absl::StatusOr<PointStore> PointStore::Open(const TilePlan& plan) {
  absl::StatusOr<InputFile> file = InputFile::Open(plan.PathOf("points.bin"));
  if (!file.ok()) return absl::FailedPreconditionError(file.status().message());
  return PointStore(plan, *std::move(file));
}

absl::Status PointStore::Append(uint64_t first, uint64_t count, std::vector<TilePoint>& points) const {
  constexpr uint64_t kPointsAtATime = 1 << 16;
  const size_t bytes = StoredBytes(plan_.is_double);
  std::string read;
  for (uint64_t done = 0; done < count;) {
    const uint64_t now = std::min(kPointsAtATime, count - done);
    read.resize(now * bytes);
    if (absl::Status status = file_.ReadAll((first + done) * bytes, read.size(), read.data()); !status.ok()) {
      return absl::FailedPreconditionError(status.message());
    }
    for (uint64_t i = 0; i < now; ++i) points.push_back(UnpackPoint(read.data() + i * bytes, plan_.is_double));
    done += now;
  }
  return absl::OkStatus();
}

}  // namespace curv
