#include "core/normals/runs/half_normals.h"

#include <algorithm>
#include <cstdint>
#include <variant>
#include <vector>

#include "core/base/halves.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/mean_copies.h"
#include "core/normals/runs/fit_run.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

// For each coefficient; with fewer neighbors, a half of them would hardly be more than the coefficients.
constexpr uint32_t kLeastNeighborsPerCoefficient = 4;
// Points at one place share their noise, but not always the half. So many groups tell how many lie at one.
constexpr size_t kMostGroups = 64;
constexpr double kMostCopies = 1.05;
// The least share of the points whose half normals are made of their half.
constexpr double kLeastMade = 0.9;

NormalPlan PlanOf(NormalFit fit, Half half, const SpatialIndex& index) {
  fit.half = half;
  return {fit, index};
}

// Whether halves of the neighbors tell enough; those of the part that is not noisy, if there is one.
bool HasEnough(const NormalFit& fit) {
  const auto* const neighbors = std::get_if<NeighborCount>(&fit.neighborhood);
  return neighbors == nullptr || neighbors->count >= LeastNeighborCountOfHalves(fit.method);
}

bool NoisyPartHasEnough(const NoisyPart& part) {
  return part.neighborhood.count >= LeastNeighborCountOfHalves(part.method);
}

class HalfNormalsRun final : public FitRun {
 public:
  HalfNormalsRun(const NormalFit& fit, SpatialIndex& index)
      : FitRun(index, {PlanOf(fit, Half::kEven, index), PlanOf(fit, Half::kOdd, index)}),
        keeps_quiet_(!HasEnough(fit)) {}

 private:
  void Write(size_t i, NormalScratch& s) const override {
    const auto place = static_cast<size_t>(s.points.place[i]);
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const SpatialIndex::LeafNormals& whole = index().normals(leaf);
    SpatialIndex::LeafNormals& half = index().mutable_half_normals(leaf);
    const double along = s.normal.x[i] * whole.x[lane] + s.normal.y[i] * whole.y[lane] + s.normal.z[i] * whole.z[lane];
    const bool keeps_whole = keeps_quiet_ && !s.is_noisy;
    // Where there is no normal, what is along it is NaN.
    const bool is_known = s.points.status[i] == PointStatus::kOk && along * along > 0.0 && !keeps_whole;
    const PointStatus counted = is_known || keeps_whole ? PointStatus::kOk : PointStatus::kTooFewNeighbors;
    ++s.status_counts[static_cast<size_t>(counted)];
    const double sign = along < 0.0 ? -1.0 : 1.0;
    half.x[lane] = is_known ? static_cast<float>(sign * s.normal.x[i]) : whole.x[lane];
    half.y[lane] = is_known ? static_cast<float>(sign * s.normal.y[i]) : whole.y[lane];
    half.z[lane] = is_known ? static_cast<float>(sign * s.normal.z[i]) : whole.z[lane];
  }

  // Beside a noisy part, points of which so few neighbors are taken have no noise to tell.
  const bool keeps_quiet_;
};

}  // namespace

uint32_t LeastNeighborCountOfHalves(NormalMethod method) {
  return kLeastNeighborsPerCoefficient * static_cast<uint32_t>(JetSize(std::max(JetDegree(method), 1)));
}

bool HasHalves(const NormalFit& fit, const SpatialIndex& index) {
  if (fit.two_sheets) return false;
  if (!(fit.noisy_part.has_value() ? NoisyPartHasEnough(*fit.noisy_part) : HasEnough(fit))) return false;
  return HasFewCopies(index);
}

bool HasFewCopies(const SpatialIndex& index) {
  const std::vector<size_t> groups = SampleGroups(index, kMostGroups);
  double copies = 0.0;
  for (const size_t group : groups) copies += MeanCopies(index, group);
  return copies <= kMostCopies * static_cast<double>(groups.size());
}

bool AreHalfNormals(std::span<const uint64_t> status_counts) {
  const auto made = static_cast<double>(status_counts[static_cast<size_t>(PointStatus::kOk)]);
  const auto others = static_cast<double>(status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)]);
  return made >= kLeastMade * (made + others);
}

std::unique_ptr<StrategyRun> StartHalfNormals(const NormalFit& fit, SpatialIndex& index) {
  return std::make_unique<HalfNormalsRun>(fit, index);
}

}  // namespace curvd
