// Counts how far the normals of a cloud with seams agree.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/estimators/seams/normals_agreement.h"
#include "core/estimators/seams/region_forest.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A region holds points that are joined by near pairs whose normals agree, on one sheet; seams and sharp edges are its
// rims. Where two regions of kLeastPatch points and more share an opposed pair, they are linked: a piece of n linked
// regions counts n - 1 flipped patches, since so many have to be turned for all to agree with the largest. If one lies
// within another, each counts.
//
// Walks over all groups with a search for the nearest points. What it counts does not depend on threads.
// REQUIRES: the phases run in order, as those of any StrategyRun; index and marks outlive the run, and nobody marks
// meanwhile.
class AgreementRun final : public StrategyRun {
 public:
  AgreementRun(const SpatialIndex& index, const SeamMarks& marks) : index_(index), marks_(marks) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override;
  std::vector<GroupPhase> Phases() override;
  size_t bytes() const override { return regions_.bytes(); }

  // All but seam_points. REQUIRES: the phases have ended.
  NormalsAgreement agreement() const {
    return {.near_pairs = near_pairs_, .opposed_pairs = opposed_pairs_, .flipped_patches = flipped_patches_};
  }

 private:
  void MeasureGroup(size_t group);

  const SpatialIndex& index_;
  const SeamMarks& marks_;
  RegionForest regions_;
  std::atomic<uint64_t> near_pairs_ = 0;
  std::atomic<uint64_t> opposed_pairs_ = 0;
  std::atomic<uint64_t> flipped_patches_ = 0;
};

}  // namespace curvd
