#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/normals/normal_fit.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/normals/fits/group_fit-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/normals/normal_fit.h"

namespace curvd {
namespace {

HWY_EXPORT(FitGroupKernel);

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class NormalFitRun final : public StrategyRun {
 public:
  NormalFitRun(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality)
      : index_(index), plan_(fit, index), quality_(quality) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<NormalScratch>(); }

  std::vector<GroupPhase> Phases() override {
    return {{"normals", nullptr, [this](size_t group, WorkerScratch& scratch) {
               return RunGroup(group, static_cast<NormalScratch&>(scratch));
             }}};
  }

 private:
  absl::Status RunGroup(size_t group, NormalScratch& s) const {
    if (absl::Status status = FitGroup(index_, plan_, group, GroupSample::kAll, s); !status.ok()) return status;
    for (size_t i = 0; i < s.points.size; ++i) Write(i, s);
    return absl::OkStatus();
  }

  void Write(size_t i, NormalScratch& s) const {
    const auto place = static_cast<size_t>(s.points.place[i]);
    SpatialIndex::LeafNormals& normals = index_.mutable_normals(place / SpatialIndex::kLeafSize);
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

  SpatialIndex& index_;
  const NormalPlan plan_;
  NormalQuality& quality_;
};

class NormalRefitRun final : public StrategyRun {
  using Vec = std::array<double, 3>;

 public:
  NormalRefitRun(const NormalFit& fit, SpatialIndex& index) : index_(index), plan_(fit, index) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<NormalScratch>(); }

  std::vector<GroupPhase> Phases() override {
    return {{"normals", nullptr, [this](size_t group, WorkerScratch& scratch) {
               return RunGroup(group, static_cast<NormalScratch&>(scratch));
             }}};
  }

 private:
  // Where a given normal is farther from the new one than this, chance has hardly told its side.
  static constexpr double kLeastCosine = 0.5;

  absl::Status RunGroup(size_t group, NormalScratch& s) const {
    if (absl::Status status = FitGroup(index_, plan_, group, GroupSample::kAll, s); !status.ok()) return status;
    for (size_t i = 0; i < s.points.size; ++i) Write(i, s);
    return absl::OkStatus();
  }

  void Write(size_t i, NormalScratch& s) const {
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
    SpatialIndex::LeafNormals& out = index_.mutable_half_normals(leaf);
    out.x[lane] = static_cast<float>(normal[0]);
    out.y[lane] = static_cast<float>(normal[1]);
    out.z[lane] = static_cast<float>(normal[2]);
  }

  // How much the given normals of the others in the leaf, the nearest above all, are on the side of `made`.
  double SideOf(const Vec& made, size_t leaf, size_t lane) const {
    const SpatialIndex::LeafPositions& at = index_.positions(leaf);
    double side = 0.0;
    for (size_t other = 0; other < static_cast<size_t>(index_.LeafPoints(leaf)); ++other) {
      const Vec offset = {static_cast<double>(at.x[other]) - at.x[lane], static_cast<double>(at.y[other]) - at.y[lane],
                          static_cast<double>(at.z[other]) - at.z[lane]};
      const double squared = Dot(offset, offset), along = Dot(made, GivenNormal(leaf, other));
      if (squared > 0.0 && !std::isnan(along)) side += along / squared;
    }
    return side;
  }

  Vec GivenNormal(size_t leaf, size_t lane) const {
    const SpatialIndex::LeafNormals& given = index_.normals(leaf);
    return {given.x[lane], given.y[lane], given.z[lane]};
  }

  static double Dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  SpatialIndex& index_;
  const NormalPlan plan_;
};

}  // namespace

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
  return options;
}

absl::Status FitGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                      NormalScratch& scratch) {
  return HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, plan, group, sample, scratch);
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
  return std::make_unique<NormalFitRun>(fit, index, quality);
}

std::unique_ptr<StrategyRun> StartNormalRefit(const NormalFit& fit, SpatialIndex& index) {
  return std::make_unique<NormalRefitRun>(fit, index);
}

}  // namespace curvd

#endif  // HWY_ONCE
