// What each worker of an automatic estimate keeps.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <typeinfo>
#include <utility>
#include <vector>

#include "core/estimators/curvature_field.h"
#include "core/estimators/group_points.h"
#include "core/estimators/strategy.h"
#include "core/scale/chosen/blend.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/parts/cloud_weights.h"
#include "core/scale/pilot/pilot_scratch.h"
#include "core/scale/point_fits/point_fit.h"

namespace curvd {

// Serves one group at a time. Arrays have a place for each of its points that get a result, from first_point on.
struct AutomaticScratch final : WorkerScratch {
  template <typename Value>
  using OfPoints = std::array<Value, SpatialIndex::kGroupPoints>;

  PilotScratch pilot;
  // Of the chosen estimates, which run one after the other: those whose scratch is of one type share it. Empty until
  // the first is asked for.
  std::vector<std::unique_ptr<WorkerScratch>> chosen;
  std::vector<size_t> place_of_chosen;  // of each estimate, in `chosen`
  std::vector<float> reach_hints;       // of each estimate, SearchScratch::reach_hint
  std::optional<CloudWeights> weights;
  std::vector<NearestSamples> samples;  // of each part, where somebody asks how points were chosen
  GroupPoints points;
  // Of the chosen estimates, at the points of each leaf that belong to each part of the cloud; and which of them are
  // large enough to count.
  std::array<std::array<CloudWeights::PointWeights, SpatialIndex::kGroupLeaves>, CloudChoice::kMostParts> leaf_weights;
  std::array<std::array<bool, CloudChoice::kMostChosen>, CloudChoice::kMostParts> counts;
  // Whether neighborhoods of a leaf's points may reach into the second part of the cloud.
  std::array<bool, SpatialIndex::kGroupLeaves> is_near_second;
  OfPoints<size_t> part;                   // of the cloud, to which a point belongs
  OfPoints<CloudWeights::Weights> shares;  // in H, of the estimates that count
  OfPoints<Blend> blends;
  // Where the cloud has edges, the same without estimates that reach over one.
  bool has_edges;
  OfPoints<Blend> clear_blends;
  OfPoints<float> edge_distances;  // in the caller's unit; infinity where there are none
  // By how much what was found of H differs from what points of the other part can make of it, in the caller's unit.
  OfPoints<double> doubts;
  OfPoints<bool> has_detail;                   // that the average smooths away, as far as the part's check tells
  OfPoints<std::optional<PointFit>> own_fits;  // in place of an average, in the caller's unit

  // Adds the scratch of the next estimate, which is a GroupScratch.
  void AddChosen(std::unique_ptr<WorkerScratch> scratch) {
    const auto is_alike = [&](const auto& other) {
      const WorkerScratch &a = *other, &b = *scratch;
      return typeid(a) == typeid(b);
    };
    const auto found = std::find_if(chosen.begin(), chosen.end(), is_alike);
    place_of_chosen.push_back(static_cast<size_t>(found - chosen.begin()));
    reach_hints.push_back(0.0f);
    if (found == chosen.end()) chosen.push_back(std::move(scratch));
  }
  // What an estimate left there is valid until another one runs.
  WorkerScratch& OfChosen(size_t estimate) const { return *chosen[place_of_chosen[estimate]]; }

  // Of the estimates that reach over no edge.
  const Blend& ClearBlend(size_t point) const { return has_edges ? clear_blends[point] : blends[point]; }

  // Of each chosen estimate at a point of the group.
  const CloudWeights::PointWeights& WeightsAt(size_t point) const { return leaf_weights[part[point]][LeafOf(point)]; }
  // In the group.
  size_t LeafOf(size_t point) const {
    return static_cast<size_t>(points.place[point]) / SpatialIndex::kLeafSize % SpatialIndex::kGroupLeaves;
  }

  size_t bytes() const override {
    size_t bytes = sizeof(*this) - sizeof(pilot) + pilot.bytes();
    for (const auto& scratch : chosen) bytes += scratch->bytes();
    for (const NearestSamples& of_part : samples) bytes += sizeof(of_part) + of_part.bytes();
    return bytes + (weights.has_value() ? weights->bytes() : 0);
  }
  uint64_t work() const override {
    uint64_t work = pilot.work();
    for (const auto& scratch : chosen) work += scratch->work();
    return work;
  }
};

}  // namespace curvd
