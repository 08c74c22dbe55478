// Finds the points of a cloud that lie off its surface, once curvature has been estimated
// (docs/numerics/automatic_choice.md, "Outliers").
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/scale/outliers/nearest_points.h"

namespace curvd {

inline constexpr std::string_view kOutlierPhase = "outliers";

// Whether an estimate by these options looks for outliers: where estimator and number of neighbors are left open.
bool LooksForOutliers(const EstimatorOptions& options);

// How a pass over a cloud looks for outliers.
enum class OutlierSearch : uint8_t {
  kNone,
  kFirst,  // there may be none: what lies off the surface by less than a fifth of the spacing may be a bend
  kAgain,  // a pass before has found many, so that others are likely: by a thirtieth
};

// An estimate is a small piece of surface: its normal and principal curvatures say where others lie. A point is an
// outlier if hardly any of its neighbors' pieces comes near it, though these explain the points around, and its
// neighbors deviate much less; or if its normal points away from those of all its neighbors. Outliers that were found
// judge no others.
//
// Walks over all groups with a search for the nearest points, several times where there are outliers. What it finds
// does not depend on threads. REQUIRES: the phases run in order, as those of any StrategyRun.
class OutlierRun final : public StrategyRun {
 public:
  // A cloud of fewer points has none.
  static constexpr size_t kFewestPoints = 100;
  // Beyond the scratch.
  static constexpr size_t kBytesPerPoint = 3 * sizeof(float) + sizeof(uint8_t) + sizeof(int32_t);

  // `results` are those of an estimate that has ended, by slot. `judges_normals`: whether single normals may be wrong,
  // as they are not where all were made of the positions. REQUIRES: `index` has normals; both outlive the run; `search`
  // is not kNone.
  OutlierRun(const SpatialIndex& index, const PointCurvature* results, bool judges_normals, OutlierSearch search)
      : index_(index), results_(results), judges_normals_(judges_normals), search_(search) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<NearestScratch>(); }
  std::vector<GroupPhase> Phases() override;
  size_t bytes() const override {
    return deviations_.bytes() + spacings_.bytes() + agreements_.bytes() + marks_.bytes();
  }

  // The ranks of the outliers, in any order; none where more than a quarter of the points would be some, since what
  // most points have in common is no exception. REQUIRES: the phases have ended.
  std::vector<int32_t> TakeOutliers();

 private:
  // Looks at outliers of that round; the first one looks at all points.
  static constexpr size_t kRounds = 4;

  absl::Status Allocate();
  absl::Status Measure(size_t group, NearestScratch& scratch);
  // Whether the nearest judges settle the point: whatever others say changes nothing.
  bool MeasurePoint(size_t i, std::span<const NearestPoint> neighbors, const NearestScratch& scratch);
  static std::span<const NearestPoint> WithoutCopies(std::span<const NearestPoint> neighbors);
  const PointCurvature& PieceOf(size_t place) const;
  // The cosine that the point's normal has with those of two neighbors at least, and no larger one with more of them;
  // NaN if too few tell.
  float AgreementOf(size_t i, std::span<const NearestPoint> neighbors, const NearestScratch& scratch) const;
  // Finds out what is usual in the cloud.
  void FindUsual();
  // Finds outliers by their normals, those that are far off, and those that may be some.
  void Judge(size_t group, size_t round);
  // Looks at the latter: outliers are those that deviate much more than the points around them.
  absl::Status Compare(size_t group, size_t round, NearestScratch& scratch);
  bool DeviatesAlone(size_t place, std::span<const NearestPoint> neighbors) const;
  // Whether a look is to be had: the first one, and others after one that found outliers.
  bool HasRound(size_t round) const { return round == 0 || found_[round - 1] > 0; }
  enum class Mark : uint8_t { kNone, kSuspect, kOutlier };

  // Whether the point has a result, or would have one but for opposed normals, and is no outlier.
  bool IsJudge(size_t place) const;
  // Whether its normal alone tells an outlier. REQUIRES: FindUsual was called, or is at it.
  bool IsLonely(size_t place) const { return agreements_[place] < lonely_cosine_; }
  // Whether what it deviates by counts for what is usual.
  bool MayBeUsual(size_t place) const {
    return IsJudge(place) && !IsLonely(place) && std::isfinite(deviations_[place]);
  }

  const PointCurvature& result(size_t place) const { return results_[index_.point_set().slot_of(rank(place))]; }
  int32_t rank(size_t place) const {
    return index_.positions(place / SpatialIndex::kLeafSize).id[place % SpatialIndex::kLeafSize];
  }

  const SpatialIndex& index_;
  const PointCurvature* const results_;
  const bool judges_normals_;
  const OutlierSearch search_;
  // By place. NaN: too few neighbors tell, or the point was found in a round before.
  PageArray<float> deviations_;  // in the index's unit
  PageArray<float> spacings_;    // likewise
  PageArray<float> agreements_;  // AgreementOf; NaN where single normals are not wrong
  PageArray<Mark> marks_;
  double usual_deviation_ = 0.0;  // over the spacing
  double lonely_cosine_ = 0.0;
  std::array<std::atomic<size_t>, kRounds> found_{};
};

}  // namespace curvd
