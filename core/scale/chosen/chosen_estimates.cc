#include "core/scale/chosen/chosen_estimates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/estimators/group_points-inl.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/seams/find_seam-inl.h"
#include "core/estimators/strategies.h"
#include "core/scale/automatic_options.h"

namespace curvd {
namespace {

// Most neighbors among which those on the side of a point are looked for.
constexpr uint32_t kMostOneSideCount = 512;

// A point whose estimates differ by more than so many times what the first part of a cloud errs by, and by more than
// the second one errs by, fares better with those of the second.
constexpr double kMostSpreadOfFirstPart = 10.0;

// Estimates of exact positions contradict each other if they differ by more than so many times what is expected.
constexpr double kMostSpreadOfExact = 4.0;

// A check for detail that differs by more than so many standard deviations of its noise tells some.
constexpr double kMostDifferenceOfCheck = 3.0;
// A point is compared with an estimate of few neighbors where it has so many times as many itself.
constexpr double kLeastTimesNear = 2.0;

// REQUIRES: first < last.
Box BoxOfLeaves(const SpatialIndex& index, size_t first, size_t last) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<size_t>(axis);
    box.lo[at] = *std::min_element(index.leaf_lo(axis) + first, index.leaf_lo(axis) + last);
    box.hi[at] = *std::max_element(index.leaf_hi(axis) + first, index.leaf_hi(axis) + last);
  }
  return box;
}

std::array<float, 3> MiddleOf(const Box& box) {
  std::array<float, 3> middle;
  for (size_t axis = 0; axis < 3; ++axis) middle[axis] = 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
  return middle;
}

// Which estimates have at least this share of the weights of some leaves, in the mean over these, of one of the
// quantities.
std::array<bool, CloudChoice::kMostChosen> ThoseThatCount(std::span<const CloudWeights::PointWeights> leaves,
                                                          double least) {
  std::array<bool, CloudChoice::kMostChosen> count{};
  using Weights = CloudWeights::Weights;
  for (const auto of : {&CloudWeights::PointWeights::mean, &CloudWeights::PointWeights::traceless,
                        &CloudWeights::PointWeights::gaussian}) {
    Weights shares{};
    for (const CloudWeights::PointWeights& leaf : leaves) {
      const Weights& weights = leaf.*of;
      const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
      for (size_t c = 0; c < weights.size() && total > 0.0; ++c) shares[c] += weights[c] / total;
    }
    const double least_share = least * std::accumulate(shares.begin(), shares.end(), 0.0);
    for (size_t c = 0; c < shares.size(); ++c) count[c] = count[c] || (shares[c] > 0.0 && shares[c] >= least_share);
  }
  return count;
}

}  // namespace

ChosenEstimates::ChosenEstimates(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
                                 EdgeRun* edges, PointCurvature* results)
    : options_(options), index_(index), choice_(choice), edges_(edges), results_(results) {
  if (edges != nullptr) edges->LookAmong(OneSideSearchCount());
  for (size_t part = 0; part < choice.parts().size(); ++part) {
    most_spread_[part] = kMostSpreadOfExact * LeastError(part);
  }
  for (const ScaleCandidate& candidate : choice.chosen()) {
    const EstimatorOptions one = OptionsOf(options, candidate.method, candidate.count());
    runs_.push_back(FindStrategy(one.estimator)->start(one, index, results));
    phases_.push_back(std::move(runs_.back()->Phases().front()));
  }
  by_count_.resize(choice.detail_check_of(0));
  std::iota(by_count_.begin(), by_count_.end(), size_t{0});
  std::stable_sort(by_count_.begin(), by_count_.end(),
                   [&](size_t a, size_t b) { return choice.chosen()[a].rung < choice.chosen()[b].rung; });
  marker_ = by_count_.front();
  for (size_t check = choice.detail_check_of(0); check < choice.chosen().size(); ++check) {
    if (choice.chosen()[check].rung < choice.chosen()[marker_].rung) marker_ = check;
  }
}

bool ChosenEstimates::HaveSmallerOnes() const {
  return choice_.chosen()[by_count_.front()].rung < choice_.chosen()[by_count_.back()].rung;
}

absl::Status ChosenEstimates::EstimateGroup(size_t group, AutomaticScratch& s) const {
  Start(group, s);
  bool looked_for_seams = s.seams == nullptr;
  const auto make = [&](size_t estimate, const auto& counts_at) {
    bool counts = false;
    for (size_t i = 0; i < s.points.size; ++i) counts = counts || counts_at(i);
    if (!counts) return absl::OkStatus();
    SeamMarks* const seams = estimate == marker_ && !looked_for_seams ? s.seams : nullptr;
    if (absl::Status status = Run(group, estimate, seams, s); !status.ok()) return status;
    for (size_t i = 0; i < s.points.size; ++i) {
      if (counts_at(i)) Add(results_[s.points.slot[i]], i, estimate, s);
    }
    if (looked_for_seams) return absl::OkStatus();
    looked_for_seams = true;
    // Whatever the smallest neighborhood of a point holds, all of them hold: it alone looks for seams.
    return estimate == marker_ || !HoldOpposed(estimate, s) ? absl::OkStatus() : Run(group, marker_, s.seams, s);
  };
  for (const size_t estimate : by_count_) {
    const auto counts_at = [&](size_t i) { return Counts(i, estimate, s); };
    if (absl::Status status = make(estimate, counts_at); !status.ok()) return status;
  }
  AutomaticScratch::OfPoints<bool> is_given{};
  if (absl::Status status = GiveToSecondPart(group, is_given, s); !status.ok()) return status;
  for (const size_t estimate : by_count_) {
    const auto counts_at = [&](size_t i) { return is_given[i] && Counts(i, estimate, s); };
    if (absl::Status status = make(estimate, counts_at); !status.ok()) return status;
  }
  AutomaticScratch::OfPoints<bool> has_none{};
  for (size_t i = 0; i < s.points.size; ++i) has_none[i] = !(s.blends[i].weight() > 0.0);
  for (const size_t estimate : by_count_) {
    const auto counts_at = [&](size_t i) { return has_none[i] && IsOfPart(i, estimate, s) && !Counts(i, estimate, s); };
    if (absl::Status status = make(estimate, counts_at); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ChosenEstimates::GiveToSecondPart(size_t group, AutomaticScratch::OfPoints<bool>& is_given,
                                               AutomaticScratch& s) const {
  if (!choice_.check().has_value()) return absl::OkStatus();
  const auto is_asked = [&](size_t i) { return s.part[i] == 0 && s.is_near_second[s.LeafOf(i)]; };
  bool any_is_asked = false;
  for (size_t i = 0; i < s.points.size; ++i) any_is_asked = any_is_asked || is_asked(i);
  if (!any_is_asked) return absl::OkStatus();
  if (absl::Status status = Run(group, *choice_.check(), nullptr, s); !status.ok()) return status;
  const double doubtful = kMostSpreadOfFirstPart * LeastError(0), hopeless = std::max(doubtful, LeastError(1));
  for (size_t i = 0; i < s.points.size; ++i) {
    if (!is_asked(i) || !(s.blends[i].weight() > 0.0)) continue;
    const PointCurvature& check = results_[s.points.slot[i]];
    const double differs = check.status == PointStatus::kOk ? std::abs(check.mean - s.blends[i].mean()) : 0.0;
    const double doubt = std::max(differs, s.blends[i].spread().mean);
    if (doubt > doubtful) s.doubts[i] = doubt;
    if (!(doubt > hopeless)) continue;
    is_given[i] = true;
    s.part[i] = 1;
    s.blends[i] = s.clear_blends[i] = {};
    s.shares[i] = {};
    s.doubts[i] = 0.0;
  }
  return absl::OkStatus();
}

absl::Status ChosenEstimates::LookForDetail(size_t group, AutomaticScratch& s) const {
  for (size_t part = 0; part < choice_.parts().size(); ++part) {
    const auto has_average = [&](size_t i) {
      return s.part[i] == part && s.ClearBlend(i).weight() > 0.0 && !IsOneSided(s, i);
    };
    // All around a small body normals cancel out, and no function of two coordinates has its heights.
    const auto looks_all_around = [&](size_t i) {
      if (s.part[i] != part || s.blends[i].weight() > 0.0) return false;
      const PointStatus status = s.blends[i].Finish().status;
      return status == PointStatus::kInconsistentNormals || status == PointStatus::kSingularFit;
    };
    bool any_is_asked = false;
    for (size_t i = 0; i < s.points.size; ++i) any_is_asked = any_is_asked || has_average(i) || looks_all_around(i);
    if (!any_is_asked) continue;
    const auto look = [&](size_t check, double most_difference, double least_count) {
      if (absl::Status status = Run(group, check, nullptr, s); !status.ok()) return status;
      const double most = std::ldexp(most_difference, index_.scale_exponent());
      for (size_t i = 0; i < s.points.size; ++i) {
        const PointCurvature& found = results_[s.points.slot[i]];
        if (found.status != PointStatus::kOk) continue;
        const bool differs =
            has_average(i) && MeanCount(i, s) >= least_count && std::abs(found.mean - s.ClearBlend(i).mean()) > most;
        s.has_detail[i] = s.has_detail[i] || differs || looks_all_around(i);
      }
      return absl::OkStatus();
    };
    const PartChoice& of = choice_.parts()[part];
    if (of.check.has_value()) {
      absl::Status status = look(choice_.detail_check_of(part), kMostDifferenceOfCheck * of.check->noise, 0.0);
      if (!status.ok()) return status;
    }
    for (size_t c = 0; c < of.near_checks.size(); ++c) {
      const NearCheck& near = of.near_checks[c];
      const double least_count = kLeastTimesNear * near.candidate.count();
      absl::Status status = look(choice_.near_checks_of(part) + c, near.most_difference, least_count);
      if (!status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

double ChosenEstimates::MeanCount(size_t point, const AutomaticScratch& s) const {
  double sum = 0.0, total = 0.0;
  for (size_t c = 0; c < choice_.chosen().size(); ++c) {
    sum += s.shares[point][c] * choice_.chosen()[c].count();
    total += s.shares[point][c];
  }
  return total > 0.0 ? sum / total : 0.0;
}

// In the caller's unit.
double ChosenEstimates::LeastError(size_t part) const {
  return std::ldexp(LeastLocalError(choice_.parts()[part].choice), index_.scale_exponent());
}

bool ChosenEstimates::HoldOpposed(size_t estimate, const AutomaticScratch& s) {
  const GroupNeighborhoods& found = static_cast<const GroupScratch&>(s.OfChosen(estimate)).neighborhoods;
  return std::any_of(found.agreement, found.agreement + s.points.size,
                     [](float agreement) { return agreement < HWY_NAMESPACE::kNoneOpposed; });
}

void ChosenEstimates::Start(size_t group, AutomaticScratch& s) const {
  if (s.chosen.empty()) {
    for (const auto& run : runs_) s.AddChosen(run->MakeScratch());
    s.weights.emplace(choice_);
  }
  s.has_edges = edges_ != nullptr && edges_->HasEdges();
  s.blends.fill({});
  if (s.has_edges) s.clear_blends.fill({});
  s.shares.fill({});
  s.doubts.fill(0.0);
  s.has_detail.fill(false);
  s.own_fits.fill(std::nullopt);
  s.rest = 0;
  HWY_NAMESPACE::LoadGroup(index_, group, s.points, s.first_point);
  StartWeights(group, s);
}

absl::Status ChosenEstimates::Run(size_t group, size_t estimate, SeamMarks* seams, AutomaticScratch& s) const {
  auto& one = static_cast<GroupScratch&>(s.OfChosen(estimate));
  one.RunWithin(s, s.most_work / runs_.size());
  one.seams = seams;
  // Others that share the scratch look at other numbers of neighbors.
  one.search.reach_hint = s.reach_hints[estimate];
  if (absl::Status status = phases_[estimate].run(group, one); !status.ok()) return status;
  s.reach_hints[estimate] = one.search.reach_hint;
  if (one.rest > 0 && (s.rest == 0 || one.rest < s.rest)) {
    s.rest = one.rest;
    s.points.size = one.rest - s.first_point;
  }
  return absl::OkStatus();
}

bool ChosenEstimates::Counts(size_t point, size_t estimate, const AutomaticScratch& s) {
  return s.counts[s.part[point]][estimate];
}

bool ChosenEstimates::IsOfPart(size_t point, size_t estimate, const AutomaticScratch& s) const {
  const size_t first = choice_.first_of(s.part[point]);
  return estimate >= first && estimate < first + choice_.parts()[s.part[point]].choice.chosen.size();
}

// The points of a leaf, and of one part of the cloud, share the weights of its middle, and those of a group share what
// counts: both are small beside the sampled points that weights come from. They do not depend on which points of the
// leaf are in the run.
void ChosenEstimates::StartWeights(size_t group, AutomaticScratch& s) const {
  if (s.points.size == 0) return;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index_.leaf_count());
  s.weights->Start(BoxOfLeaves(index_, first, last));
  for (size_t part = 0; part < choice_.parts().size(); ++part) {
    for (size_t leaf = first; leaf < last; ++leaf) {
      const std::array<float, 3> middle = MiddleOf(BoxOfLeaves(index_, leaf, leaf + 1));
      s.is_near_second[leaf - first] = s.weights->IsNearSecond(middle.data());
      s.leaf_weights[part][leaf - first] = s.weights->At(middle.data(), part);
    }
    const double least = choice_.parts()[part].positions_are_exact ? kLeastWeightOfExact : kLeastWeight;
    s.counts[part] = ThoseThatCount(std::span(s.leaf_weights[part]).first(last - first), least);
  }
  for (size_t i = 0; i < s.points.size; ++i) {
    float position[3];
    s.points.query.Get(i, position);
    s.part[i] = s.weights->PartAt(position);
  }
  if (!s.has_edges) {
    s.edge_distances.fill(std::numeric_limits<float>::infinity());
    return;
  }
  for (size_t i = 0; i < s.points.size; ++i) {
    float position[3];
    s.points.query.Get(i, position);
    s.edge_distances[i] = std::ldexp(edges_->DistanceToEdge(position), -index_.scale_exponent());
  }
}

void ChosenEstimates::Add(PointCurvature found, size_t point, size_t estimate, AutomaticScratch& s) const {
  const double most_radius = ScaleOf(options_).max_radius;
  const bool is_too_large = found.status == PointStatus::kOk && found.radius > most_radius;
  if (most_radius > 0.0 && is_too_large) found.status = PointStatus::kTooFewNeighbors;
  const CloudWeights::PointWeights& weights = s.WeightsAt(point);
  const OfQuantities<double> of_estimate = {weights.mean[estimate], weights.traceless[estimate],
                                            weights.gaussian[estimate]};
  const size_t part = s.part[point];
  const auto most_spread = choice_.MayBeSteady(estimate) ? std::optional(most_spread_[part]) : std::nullopt;
  s.blends[point].Add(found, of_estimate, most_spread);
  // Results without curvature count: if there are no others, they tell why.
  const bool is_ok = found.status == PointStatus::kOk;
  if (s.has_edges) {
    if (is_ok && !(found.radius < s.edge_distances[point])) return;
    s.clear_blends[point].Add(found, of_estimate, most_spread);
  }
  if (is_ok) s.shares[point][estimate] = of_estimate.mean;
}

absl::Status ChosenEstimates::EstimateOneSided(size_t group, AutomaticScratch& s) const {
  AutomaticScratch::OfPoints<size_t> one_sided;
  size_t count = 0;
  for (size_t i = 0; i < s.points.size; ++i) {
    if (IsOneSided(s, i)) one_sided[count++] = i;
  }
  if (count == 0) return absl::OkStatus();
  s.pilot.RunWithin(s, WorkerScratch::kNoLimit);  // a group's points are few
  const double most_radius = ScaleOf(options_).max_radius;
  const float most_in_index = most_radius > 0.0 ? static_cast<float>(std::ldexp(most_radius, index_.scale_exponent()))
                                                : std::numeric_limits<float>::max();
  return edges_->Repair(
      group, most_in_index, [&](size_t i) { return i < s.points.size && IsOneSided(s, i); },
      [&](const float* position) { return ScaleAt(position, *s.weights); },
      [&](size_t place, const PointFit& found) {
        const size_t i = one_sided[place];
        results_[s.points.slot[i]] = found.point;
        s.own_fits[i] = found;
      },
      s.pilot);
}

// Twice as many as the choice takes: on a straight edge, half of them are on the side of a point.
uint32_t ChosenEstimates::OneSideSearchCount() const {
  constexpr double kLeastShare = 0.1;
  uint32_t count = ScaleOf(options_).least_count;
  for (const PartChoice& part : choice_.parts()) {
    for (size_t c = 0; c < part.choice.chosen.size(); ++c) {
      if (part.choice.weights.mean.cloud_weights[c] >= kLeastShare)
        count = std::max(count, part.choice.chosen[c].count());
    }
  }
  return std::min({2 * count, kMostOneSideCount, MostSampledCount(options_)});
}

// As many neighbors as the choice would take without the edge: the mean over its weights.
OneSideScale ChosenEstimates::ScaleAt(const float* position, CloudWeights& weights) const {
  const size_t part = weights.PartAt(position);
  const CloudWeights::PointWeights at = weights.At(position, part);
  double logarithms = 0.0, total = 0.0;
  for (size_t c = 0; c < choice_.chosen().size(); ++c) {
    logarithms += at.mean[c] * std::log(static_cast<double>(choice_.chosen()[c].count()));
    total += at.mean[c];
  }
  return {std::min<size_t>(static_cast<size_t>(std::lround(std::exp(logarithms / total))), kMostOneSideCount / 2),
          2.0 * std::ldexp(LeastError(part), -index_.scale_exponent()), ScaleOf(options_).least_count};
}

}  // namespace curvd
