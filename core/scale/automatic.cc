#include "core/scale/automatic.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/estimators/strategies.h"
#include "core/scale/blend.h"
#include "core/scale/local_weights.h"
#include "core/scale/pilot.h"
#include "core/scale/scale_choice.h"
#include "core/scale/scale_report.h"

namespace curvd {
namespace {

AutomaticScale ScaleOf(const EstimatorOptions& options) {
  if (const auto* scale = std::get_if<AutomaticScale>(&options.neighborhood)) return *scale;
  return {};
}

// The count that every estimate has, where only the estimator is left open.
std::optional<uint32_t> FixedCount(const EstimatorOptions& options) {
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  return count != nullptr ? std::optional(count->count) : std::nullopt;
}

// The rung that is nearest to a count, on the scale of its ratios.
size_t RungNear(uint32_t count) {
  const auto distance = [count](uint32_t rung) { return std::abs(std::log(static_cast<double>(rung) / count)); };
  const auto nearest = std::min_element(kScaleRungs.begin(), kScaleRungs.end(),
                                        [&](uint32_t a, uint32_t b) { return distance(a) < distance(b); });
  return static_cast<size_t>(nearest - kScaleRungs.begin());
}

bool IsCandidate(const EstimatorOptions& options, size_t method) {
  return options.estimator == kAutomaticEstimator || options.estimator == kScaleMethods[method].estimator;
}

// The options of the estimate that a method makes from so many neighbors.
EstimatorOptions OptionsOf(const EstimatorOptions& options, size_t method, uint32_t count) {
  EstimatorOptions one = options;
  one.estimator = kScaleMethods[method].estimator;
  if (kScaleMethods[method].jet_degree != 0) one.jet_degree = kScaleMethods[method].jet_degree;
  one.neighborhood = NeighborCount{FixedCount(options).value_or(count)};
  return one;
}

// The largest neighborhood that may be looked at.
uint32_t MostCount(const EstimatorOptions& options) {
  return std::min(FixedCount(options).value_or(ScaleOf(options).most_count), options.max_neighbor_count);
}

// Rungs above the largest neighborhood that is allowed: what that one is compared with.
uint32_t MostSampledCount(const EstimatorOptions& options) {
  const size_t rung = std::min(RungNear(MostCount(options)) + 2, kRungCount - 1);
  return kScaleRungs[rung];
}

EstimatorOptions PilotOptions(const EstimatorOptions& options) {
  EstimatorOptions pilot;
  pilot.neighborhood = NeighborCount{MostSampledCount(options)};
  return pilot;
}

ScaleBounds BoundsOf(const EstimatorOptions& options, const SpatialIndex& index) {
  ScaleBounds bounds;
  for (size_t m = 0; m < kMethodCount; ++m) bounds.methods[m] = IsCandidate(options, m);
  const AutomaticScale scale = ScaleOf(options);
  bounds.per_cloud = scale.per_cloud;
  if (const auto count = FixedCount(options)) {
    bounds.least_count = bounds.most_count = kScaleRungs[RungNear(*count)];
    return bounds;
  }
  bounds.least_count = scale.least_count;
  bounds.most_count = MostCount(options);
  if (scale.max_radius > 0.0) {
    bounds.most_radius = static_cast<float>(std::ldexp(scale.max_radius, index.scale_exponent()));
  }
  return bounds;
}

struct AutomaticScratch final : WorkerScratch {
  PilotScratch pilot;
  std::vector<std::unique_ptr<WorkerScratch>> chosen;  // of the chosen estimates
  std::optional<LocalWeights> weights;
  // Of the points of the group at hand.
  std::array<LocalWeights::Weights, SpatialIndex::kGroupPoints> point_weights;
  std::array<Blend, SpatialIndex::kGroupPoints> blends;

  size_t bytes() const override {
    size_t bytes = sizeof(*this) - sizeof(pilot) + pilot.bytes();
    for (const auto& scratch : chosen) bytes += scratch->bytes();
    return bytes + (weights.has_value() ? weights->bytes() : 0);
  }
  uint64_t work() const override {
    uint64_t work = pilot.work();
    for (const auto& scratch : chosen) work += scratch->work();
    return work;
  }
};

// Samples, chooses, then estimates group by group by all chosen estimators and averages.
class AutomaticRun final : public StrategyRun {
 public:
  AutomaticRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* results)
      : options_(options), index_(index), results_(results), pilot_(index, MostSampledCount(options)) {
    table_.resize(pilot_.rung_count() > 0 ? pilot_.sample_count() : 0, PilotPoint::None());
  }

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<AutomaticScratch>(); }

  std::vector<GroupPhase> Phases() override {
    std::vector<GroupPhase> phases;
    phases.push_back({"scale", nullptr, [this](size_t group, WorkerScratch& scratch) {
                        return Sample(group, static_cast<AutomaticScratch&>(scratch));
                      }});
    phases.push_back({"curvature",
                      [this] {
                        Choose();
                        return absl::OkStatus();
                      },
                      [this](size_t group, WorkerScratch& scratch) {
                        return Estimate(group, static_cast<AutomaticScratch&>(scratch));
                      }});
    return phases;
  }

  size_t bytes() const override {
    return table_.capacity() * sizeof(PilotPoint) +
           choice_.local_errors.capacity() * sizeof(choice_.local_errors.front());
  }

  const ScaleReport* scale_report() const override { return &report_; }

 private:
  absl::Status Sample(size_t group, AutomaticScratch& s) {
    if (table_.empty()) return absl::OkStatus();
    s.pilot.stopped = s.stopped;
    return pilot_.SampleGroup(group, s.pilot, table_);
  }

  void Choose() {
    std::erase_if(table_, [](const PilotPoint& point) { return !point.is_sampled(); });
    choice_ = ChooseScales(table_, BoundsOf(options_, index_));
    Report();
    if (choice_.chosen.empty()) {
      choice_.chosen = {Fallback()};
      choice_.cloud_weights = {1.0};
    }
    for (const ScaleCandidate& candidate : choice_.chosen) {
      const EstimatorOptions one = OptionsOf(options_, candidate.method, candidate.count());
      runs_.push_back(FindStrategy(one.estimator)->start(one, index_, results_));
      phases_.push_back(std::move(runs_.back()->Phases().front()));
    }
  }

  // What is tried where nothing could be judged: what comes of it has a status.
  ScaleCandidate Fallback() const {
    size_t method = 0;
    while (!IsCandidate(options_, method)) ++method;
    size_t rung = RungNear(FixedCount(options_).value_or(ScaleOf(options_).least_count));
    while (rung > 0 && kScaleRungs[rung] > index_.point_count()) --rung;
    return {method, rung};
  }

  void Report() {
    report_.sampled_points = static_cast<uint32_t>(table_.size());
    report_.sigma = std::ldexp(choice_.sigma, -index_.scale_exponent());
    const auto to_caller = [&](double curvature) { return std::ldexp(curvature, index_.scale_exponent()); };
    for (const ScaleScore& score : choice_.scores) {
      report_.outcomes.push_back({kScaleMethods[score.candidate.method].estimator,
                                  FixedCount(options_).value_or(score.candidate.count()), to_caller(score.error),
                                  to_caller(score.noise), to_caller(score.bias), score.share});
    }
  }

  // Estimates the group from s.first_point on, as far as all chosen estimators come in a run of their own: what one of
  // them has estimated beyond that is estimated again.
  absl::Status Estimate(size_t group, AutomaticScratch& s) {
    if (s.chosen.empty()) {
      for (const auto& run : runs_) s.chosen.push_back(run->MakeScratch());
      s.weights.emplace(table_, choice_);
    }
    s.blends.fill({});
    size_t done = SpatialIndex::kGroupPoints;
    s.rest = 0;
    for (size_t c = 0; c < s.chosen.size(); ++c) {
      WorkerScratch& one = *s.chosen[c];
      one.stopped = s.stopped;
      one.seams = s.seams;
      one.most_work = s.most_work / s.chosen.size();
      one.first_point = s.first_point;
      one.rest = 0;
      if (absl::Status status = phases_[c].run(group, one); !status.ok()) return status;
      const GroupPoints& points = static_cast<const GroupScratch&>(one).points;
      if (one.rest > 0 && (s.rest == 0 || one.rest < s.rest)) s.rest = one.rest;
      done = std::min(done, points.size);
      if (c == 0) StartWeights(points, s);
      for (size_t i = 0; i < done; ++i) Add(points, i, c, s);
    }
    const GroupPoints& points = static_cast<const GroupScratch&>(*s.chosen.front()).points;
    for (size_t i = 0; i < done; ++i) {
      const PointCurvature point = s.blends[i].Finish();
      ++s.status_counts[static_cast<size_t>(point.status)];
      results_[points.slot[i]] = point;
    }
    return absl::OkStatus();
  }

  void StartWeights(const GroupPoints& points, AutomaticScratch& s) {
    if (points.size == 0) return;
    s.weights->Start(points.box);
    for (size_t i = 0; i < points.size; ++i) {
      float position[3];
      points.query.Get(i, position);
      s.point_weights[i] = s.weights->At(position);
    }
  }

  void Add(const GroupPoints& points, size_t i, size_t c, AutomaticScratch& s) const {
    PointCurvature estimate = results_[points.slot[i]];
    const double most_radius = ScaleOf(options_).max_radius;
    const bool is_too_large = estimate.status == PointStatus::kOk && estimate.radius > most_radius;
    if (most_radius > 0.0 && is_too_large) estimate.status = PointStatus::kTooFewNeighbors;
    s.blends[i].Add(estimate, s.point_weights[i][c]);
  }

  const EstimatorOptions options_;
  const SpatialIndex& index_;
  PointCurvature* const results_;
  const Pilot pilot_;
  PilotTable table_;
  ScaleChoice choice_;
  ScaleReport report_;
  std::vector<std::unique_ptr<StrategyRun>> runs_;  // of the chosen estimators
  std::vector<GroupPhase> phases_;                  // of each, the only one
};

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  size_t chosen = 0;
  for (size_t m = 0; m < kMethodCount; ++m) {
    if (!IsCandidate(options, m)) continue;
    const EstimatorOptions one = OptionsOf(options, m, MostCount(options));
    chosen = std::max(chosen, FindStrategy(one.estimator)->scratch_bytes(one, point_count));
  }
  return sizeof(AutomaticScratch) - sizeof(PilotScratch) + PilotScratch::MostBytes(PilotOptions(options), point_count) +
         LocalWeights::MostBytes(Pilot::kMostPoints) + ScaleChoice::kMostChosen * (chosen + sizeof(void*));
}

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<AutomaticRun>(options, index, results);
}

constexpr Strategy kAutomatic = {.name = kAutomaticEstimator,
                                 .wire_name = {},
                                 .summary = "the estimators and scales that suit the cloud, averaged",
                                 .options = {},
                                 .needs_normals = true,
                                 .bytes_per_point = 0,
                                 .scratch_bytes = MostScratchBytes,
                                 .start = Start};

}  // namespace

const Strategy& StrategyFor(const EstimatorOptions& options) {
  return options.is_automatic() ? kAutomatic : *FindStrategy(options.estimator);
}

uint32_t LeastPoints(const EstimatorOptions& options) {
  if (const auto count = FixedCount(options)) return *count;
  return std::holds_alternative<AutomaticScale>(options.neighborhood) ? kScaleRungs[0] : 0;
}

}  // namespace curvd
