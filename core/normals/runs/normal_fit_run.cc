#include "core/normals/runs/normal_fit_run.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/runs/fit_run.h"

namespace curvd {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class NormalFitRun final : public FitRun {
 public:
  NormalFitRun(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality)
      : FitRun(index, {NormalPlan(fit, index)}), quality_(quality) {}

 private:
  void Write(size_t i, NormalScratch& s) const override {
    const auto place = static_cast<size_t>(s.points.place[i]);
    SpatialIndex::LeafNormals& normals = index().mutable_normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    const PointStatus status = s.points.status[i];
    const bool ok = status == PointStatus::kOk;
    normals.x[lane] = ok ? static_cast<float>(s.normal.x[i]) : kNan;
    normals.y[lane] = ok ? static_cast<float>(s.normal.y[i]) : kNan;
    normals.z[lane] = ok ? static_cast<float>(s.normal.z[i]) : kNan;
    quality_.status[place] = status;
    if (quality_.residual.size() > 0) {
      quality_.residual[place] = ok ? static_cast<float>(std::sqrt(s.mean_square[i])) : kNan;
      quality_.variance_ratio[place] = ok ? static_cast<float>(s.variance_ratio[i]) : kNan;
    }
    if (s.points.slot[i] != GroupPoints::kNoSlot) ++s.status_counts[static_cast<size_t>(status)];
  }

  NormalQuality& quality_;
};

}  // namespace

absl::Status NormalQuality::Create(size_t places, bool wants_all) {
  auto statuses = PageArray<PointStatus>::Create(places);
  if (!statuses.ok()) return statuses.status();
  status = *std::move(statuses);
  for (PageArray<float>* array : {&residual, &variance_ratio}) {
    auto values = PageArray<float>::Create(wants_all ? places : 0);
    if (!values.ok()) return values.status();
    *array = *std::move(values);
  }
  return absl::OkStatus();
}

std::unique_ptr<StrategyRun> StartNormalFit(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality) {
  index.set_shows_edges(fit.edge_part.has_value());
  return std::make_unique<NormalFitRun>(fit, index, quality);
}

}  // namespace curvd
