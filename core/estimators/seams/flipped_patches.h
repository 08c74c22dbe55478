// Counts the parts of a cloud whose normals point to the other side than those around them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/estimators/seams/region_forest.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A region holds points that are joined by near pairs (NormalsAgreement::kNearest) whose normals agree, on one sheet;
// seams and sharp edges are its rims. The patches are what regions of kLeastPatch points and more have to be turned so
// that they agree with the largest of those that they meet at seams: their number, less one for each piece of such
// regions. Of nested patches each counts.
//
// Walks over all groups with a search for the nearest points: about a tenth of an estimate by 50 neighbors. The number
// does not depend on threads. REQUIRES: the phases run in order, as those of any StrategyRun; index and marks outlive
// the run, and nobody marks meanwhile.
class FlippedPatches final : public StrategyRun {
 public:
  // Smaller regions are single points and the chance of noise.
  static constexpr size_t kLeastPatch = 10;

  FlippedPatches(const SpatialIndex& index, const SeamMarks& marks) : index_(index), marks_(marks) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override;
  std::vector<GroupPhase> Phases() override;
  size_t bytes() const override { return regions_.bytes(); }

  // REQUIRES: all phases have ended.
  uint64_t count() const { return count_; }

 private:
  void MeasureGroup(size_t group);

  const SpatialIndex& index_;
  const SeamMarks& marks_;
  RegionForest regions_;
  std::atomic<uint64_t> count_ = 0;
};

}  // namespace curvd
