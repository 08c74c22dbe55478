#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/normals/normal_fit.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/normals/fits/group_fit-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/median.h"
#include "core/normals/edges/edge_fits.h"
#include "core/normals/normal_fit.h"
#include "core/normals/runs/fit_run.h"

namespace curvd {
namespace {

HWY_EXPORT(FitGroupKernel);

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

NormalFit FitOfNoisyPart(const NormalFit& whole) {
  NormalFit fit = whole;
  fit.method = whole.noisy_part->method;
  fit.neighborhood = whole.noisy_part->neighborhood;
  fit.shares = whole.noisy_part->shares;
  fit.crosses_lines = whole.noisy_part->crosses_lines;
  fit.noisy_part.reset();
  return fit;
}

NormalFit QuadricFit(uint32_t neighbor_count) {
  NormalFit fit;
  fit.neighborhood = NeighborCount{neighbor_count};
  return fit;
}

// How far the points of a group, one of each leaf, lie from their fits, squared, in the median; 0 without a fit. Of all
// runs of the group's points, and of fits to halves, the same.
absl::StatusOr<double> VarianceOf(const SpatialIndex& index, const NormalPlan& plan, size_t group, NormalScratch& s) {
  NormalPlan whole = plan;
  whole.half.reset();
  const size_t first_point = std::exchange(s.first_point, 0);
  const uint64_t most_work = std::exchange(s.most_work, std::numeric_limits<uint64_t>::max());
  const auto take = std::exchange(s.take, nullptr);
  const absl::Status status = HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, whole, group, GroupSample::kOneOfEachLeaf, s);
  s.first_point = first_point;
  s.most_work = most_work;
  s.take = take;
  if (!status.ok()) return status;
  std::vector<double> variances;
  for (size_t i = 0; i < s.points.size; ++i) {
    const double rho = s.frames.rho[i];
    if (s.points.status[i] == PointStatus::kOk) variances.push_back(s.mean_square[i] * rho * rho);
  }
  return variances.empty() ? 0.0 : Median(variances);
}

}  // namespace

NormalPlan::NormalPlan(const NormalFit& fit, const SpatialIndex& index)
    : neighborhood(NeighborhoodPlan::Make(fit.ToEstimatorOptions(), index)),
      degree(JetDegree(fit.method)),
      two_sheets(fit.two_sheets),
      shares(fit.shares),
      crosses_lines(fit.crosses_lines),
      half(fit.half) {
  if (fit.edge_part.has_value()) edges = std::make_shared<EdgePlan>(PlanEdges(fit, index));
  if (!fit.noisy_part.has_value()) return;
  NoisyPlan plans{NormalPlan(QuadricFit(fit.noisy_part->probe_count), index),
                  NormalPlan(FitOfNoisyPart(fit), index),
                  {},
                  fit.noisy_part->least_variance,
                  fit.noisy_part->quiet_variance};
  NormalFit quiet = fit;
  quiet.noisy_part.reset();
  const uint32_t least = std::max(fit.noisy_part->probe_count, LeastNeighborCount(fit.method));
  for (uint32_t count = std::get<NeighborCount>(fit.neighborhood).count;; count /= 2) {
    quiet.neighborhood = NeighborCount{count};
    quiet.shares = fit.shares && count >= NormalFit::kLeastShared;
    plans.quiet.push_back(NormalPlan(quiet, index));
    if (count <= least) break;
  }
  noisy = std::make_shared<NoisyPlan>(std::move(plans));
}

EstimatorOptions NormalFit::ToEstimatorOptions() const {
  EstimatorOptions options;
  options.estimator = "jet";
  std::visit([&options](const auto& points) { options.neighborhood = points; }, neighborhood);
  options.jet_degree = static_cast<uint32_t>(std::max(JetDegree(method), 1));
  options.max_neighbor_count = max_neighbor_count;
  return options;
}

EstimatorOptions NormalFit::OptionsForOnePoint() const {
  EstimatorOptions options = ToEstimatorOptions();
  auto* const neighbors = std::get_if<NeighborCount>(&options.neighborhood);
  if (shares && neighbors != nullptr) neighbors->count /= SpatialIndex::kLeafSize;
  if (!noisy_part.has_value()) return options;
  EstimatorOptions noisy = FitOfNoisyPart(*this).OptionsForOnePoint();
  return std::get<NeighborCount>(noisy.neighborhood).count > std::get<NeighborCount>(options.neighborhood).count
             ? noisy
             : options;
}

NormalFit PlaneFit(size_t neighbor_count) {
  NormalFit fit;
  fit.method = NormalMethod::kPca;
  fit.neighborhood = NeighborCount{static_cast<uint32_t>(neighbor_count)};
  return fit;
}

absl::StatusOr<const NormalPlan*> PlanOfGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group,
                                              NormalScratch& scratch) {
  if (plan.noisy == nullptr) return &plan;
  const NoisyPlan& noisy = *plan.noisy;
  const absl::StatusOr<double> probed = VarianceOf(index, noisy.probe, group, scratch);
  if (!probed.ok()) return probed.status();
  if (*probed >= noisy.least_variance) return &noisy.fit;
  const double least_mixed = NoisyPart::kMixedRatio * std::max(*probed, noisy.quiet_variance);
  for (const NormalPlan& quiet : noisy.quiet) {
    if (&quiet == &noisy.quiet.back()) break;
    const absl::StatusOr<double> variance = VarianceOf(index, quiet, group, scratch);
    if (!variance.ok()) return variance.status();
    if (*variance < least_mixed) return &quiet;
  }
  return &noisy.quiet.back();
}

absl::Status FitChosen(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                       NormalScratch& scratch) {
  return HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, plan, group, sample, scratch);
}

absl::Status FitGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                      NormalScratch& scratch) {
  const absl::StatusOr<const NormalPlan*> own = PlanOfGroup(index, plan, group, scratch);
  if (!own.ok()) return own.status();
  scratch.is_noisy = plan.noisy != nullptr && *own == &plan.noisy->fit;
  if (plan.edges != nullptr) return FitBesideEdges(index, plan, group, sample, scratch);
  return HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, **own, group, sample, scratch);
}

NormalScratch& SampleScratch::Of(int worker, const std::atomic<bool>& stopped) {
  std::unique_ptr<NormalScratch>& scratch = of_worker_[static_cast<size_t>(worker)];
  if (scratch == nullptr) {
    scratch = std::make_unique<NormalScratch>();
    scratch->most_work = std::numeric_limits<uint64_t>::max();  // a few points are no work
  }
  scratch->stopped = &stopped;
  return *scratch;
}

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

std::vector<size_t> SampleGroups(const SpatialIndex& index, size_t most) {
  const size_t groups = std::min(index.group_count(), most);
  std::vector<size_t> sample;
  sample.reserve(groups);
  for (size_t i = 0; i < groups; ++i) sample.push_back((2 * i + 1) * index.group_count() / (2 * groups));
  return sample;
}

double LatticeStep(const SpatialIndex& index) {
  constexpr size_t kMostLeaves = 4096;
  // Of n values at random in an interval, the two that lie nearest to each other are a part of 1 / n^2 apart.
  constexpr double kMoreThanChance = 30.0;
  const size_t step = std::max<size_t>(index.leaf_count() / kMostLeaves, 1);
  double finest = std::numeric_limits<double>::infinity();
  for (const auto axis :
       {&SpatialIndex::LeafPositions::x, &SpatialIndex::LeafPositions::y, &SpatialIndex::LeafPositions::z}) {
    std::vector<float> values;
    for (size_t leaf = 0; leaf < index.leaf_count(); leaf += step) {
      values.push_back((index.positions(leaf).*axis)[0]);
    }
    std::sort(values.begin(), values.end());
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 1; i < values.size(); ++i) {
      const double gap = static_cast<double>(values[i]) - values[i - 1];
      if (gap > 0.0) least = std::min(least, gap);
    }
    const double extent = static_cast<double>(values.back()) - values.front();
    const double count = static_cast<double>(values.size());
    if (extent > 0.0) finest = std::min(finest, least * count * count > kMoreThanChance * extent ? least : 0.0);
  }
  return std::isfinite(finest) ? finest : 0.0;
}

std::unique_ptr<StrategyRun> StartNormalFit(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality) {
  index.set_shows_edges(fit.edge_part.has_value());
  return std::make_unique<NormalFitRun>(fit, index, quality);
}

}  // namespace curvd

#endif  // HWY_ONCE
