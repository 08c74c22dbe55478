#include "core/normals/runs/normal_refit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/runs/fit_run.h"

namespace curvd {
namespace {

class NormalRefitRun final : public FitRun {
  using Vec = std::array<double, 3>;

 public:
  NormalRefitRun(const NormalFit& fit, SpatialIndex& index) : FitRun(index, {NormalPlan(fit, index)}) {}

 private:
  // Of the angle between a given normal and the new one. Where it is less, the given one tells the side little better
  // than chance.
  static constexpr double kLeastCosine = 0.5;

  void Write(size_t i, NormalScratch& s) const override {
    const auto place = static_cast<size_t>(s.points.place[i]);
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    Vec normal = GivenNormal(leaf, lane);
    const bool is_made = s.points.status[i] == PointStatus::kOk && !std::isnan(normal[0]);
    ++s.status_counts[static_cast<size_t>(is_made ? PointStatus::kOk : PointStatus::kTooFewNeighbors)];
    if (is_made) {
      const Vec made = {s.normal.x[i], s.normal.y[i], s.normal.z[i]};
      const double along = Dot(made, normal), side = std::abs(along) < kLeastCosine ? SideOf(made, leaf, lane) : along;
      for (size_t axis = 0; axis < 3; ++axis) normal[axis] = side < 0.0 ? -made[axis] : made[axis];
    }
    SpatialIndex::LeafNormals& out = index().mutable_half_normals(leaf);
    out.x[lane] = static_cast<float>(normal[0]);
    out.y[lane] = static_cast<float>(normal[1]);
    out.z[lane] = static_cast<float>(normal[2]);
  }

  // How much the given normals of the others in the group, the nearest above all, are on the side of `made`.
  double SideOf(const Vec& made, size_t leaf, size_t lane) const {
    const SpatialIndex::LeafPositions& at = index().positions(leaf);
    const size_t first = leaf / SpatialIndex::kGroupLeaves * SpatialIndex::kGroupLeaves;
    const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index().leaf_count());
    double side = 0.0;
    for (size_t other_leaf = first; other_leaf < last; ++other_leaf) {
      const SpatialIndex::LeafPositions& others = index().positions(other_leaf);
      for (size_t other = 0; other < static_cast<size_t>(index().LeafPoints(other_leaf)); ++other) {
        const Vec offset = {static_cast<double>(others.x[other]) - at.x[lane],
                            static_cast<double>(others.y[other]) - at.y[lane],
                            static_cast<double>(others.z[other]) - at.z[lane]};
        const double squared = Dot(offset, offset), along = Dot(made, GivenNormal(other_leaf, other));
        if (squared > 0.0 && !std::isnan(along)) side += along / std::sqrt(squared);
      }
    }
    return side;
  }

  Vec GivenNormal(size_t leaf, size_t lane) const {
    const SpatialIndex::LeafNormals& given = index().normals(leaf);
    return {given.x[lane], given.y[lane], given.z[lane]};
  }

  static double Dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
};

}  // namespace

std::unique_ptr<StrategyRun> StartNormalRefit(const NormalFit& fit, SpatialIndex& index) {
  index.set_shows_edges(fit.edge_part.has_value());
  return std::make_unique<NormalRefitRun>(fit, index);
}

}  // namespace curvd
