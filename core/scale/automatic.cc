#include "core/scale/automatic.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/estimators/seams/seam_reach.h"
#include "core/estimators/strategies.h"
#include "core/scale/automatic_options.h"
#include "core/scale/blend.h"
#include "core/scale/edges/edge_run.h"
#include "core/scale/error_samples.h"
#include "core/scale/local_weights.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/pilot.h"
#include "core/scale/scale_choice.h"
#include "core/scale/scale_report.h"
#include "core/scale/standard_errors.h"

namespace curvd {
namespace {

EstimatorOptions PilotOptions(const EstimatorOptions& options) {
  EstimatorOptions pilot;
  pilot.neighborhood = NeighborCount{MostSampledCount(options)};
  return pilot;
}

// Most neighbors among which those on the side of a point are looked for.
constexpr uint32_t kMostOneSideCount = 512;
// Of the weights at a point, so many must belong to estimates that reach over no edge.
constexpr double kLeastClearShare = 0.1;
// Standard errors are those of all chosen estimates: a point that has lost more of their weights has none.
constexpr double kLeastShareWithErrors = 0.9;

struct AutomaticScratch final : WorkerScratch {
  PilotScratch pilot;
  std::vector<std::unique_ptr<WorkerScratch>> chosen;  // of the chosen estimates
  std::optional<LocalWeights> weights;
  std::optional<NearestSamples> samples;
  // Of the points of the group at hand.
  std::array<LocalWeights::PointWeights, SpatialIndex::kGroupPoints> point_weights;
  std::array<LocalWeights::Weights, SpatialIndex::kGroupPoints> shares;  // in H, of the estimates that count
  std::array<Blend, SpatialIndex::kGroupPoints> blends;
  // The same without estimates that reach over an edge.
  std::array<Blend, SpatialIndex::kGroupPoints> clear_blends;
  std::array<float, SpatialIndex::kGroupPoints> edge_distances;  // in the caller's unit
  // While points beside seams are mended: those whose next larger estimates are not asked any more, and what all points
  // were before.
  std::array<bool, SpatialIndex::kGroupPoints> is_closed;
  std::array<PointCurvature, SpatialIndex::kGroupPoints> before;

  size_t bytes() const override {
    size_t bytes = sizeof(*this) - sizeof(pilot) + pilot.bytes();
    for (const auto& scratch : chosen) bytes += scratch->bytes();
    return bytes + (weights.has_value() ? weights->bytes() : 0) + (samples.has_value() ? samples->bytes() : 0);
  }
  uint64_t work() const override {
    uint64_t work = pilot.work();
    for (const auto& scratch : chosen) work += scratch->work();
    return work;
  }
};

// Samples, chooses, then estimates group by group by all chosen estimators and averages. Where there are seams, it
// averages once more, at points whose largest neighborhoods reach across one, those whose neighborhoods do not.
class AutomaticRun final : public StrategyRun {
 public:
  AutomaticRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* results)
      : options_(options), index_(index), results_(results), pilot_(index, MostSampledCount(options)) {
    table_.resize(pilot_.rung_count() > 0 ? pilot_.sample_count() : 0, PilotPoint::None());
    if (MindsEdges(options)) edges_.emplace(index);
  }

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<AutomaticScratch>(); }

  std::vector<GroupPhase> Phases() override {
    std::vector<GroupPhase> phases;
    phases.push_back({"scale", nullptr, [this](size_t group, WorkerScratch& scratch) {
                        return Sample(group, static_cast<AutomaticScratch&>(scratch));
                      }});
    if (edges_.has_value()) {
      phases.push_back({"roughness", nullptr, [this](size_t group, WorkerScratch& scratch) {
                          return MeasureEdges(group, static_cast<AutomaticScratch&>(scratch));
                        }});
      phases.push_back({"edges",
                        [this] {
                          edges_->Sample(PositionNoise(SampledPoints()));
                          return absl::OkStatus();
                        },
                        [this](size_t group, WorkerScratch&) {
                          edges_->Mark(group);
                          return absl::OkStatus();
                        }});
    }
    phases.push_back({"curvature",
                      [this] {
                        Choose();
                        return absl::OkStatus();
                      },
                      [this](size_t group, WorkerScratch& scratch) {
                        return Estimate(group, static_cast<AutomaticScratch&>(scratch));
                      }});
    if (options_.is_automatic()) {
      phases.push_back({"seams",
                        [this] {
                          LookForSeams();
                          return absl::OkStatus();
                        },
                        [this](size_t group, WorkerScratch& scratch) {
                          return MendAtSeams(group, static_cast<AutomaticScratch&>(scratch));
                        }});
    }
    return phases;
  }

  size_t bytes() const override {
    return table_.capacity() * sizeof(PilotPoint) + choice_.mean.bytes() + choice_.gaussian.bytes() + errors_.bytes() +
           (edges_.has_value() ? edges_->bytes() : 0);
  }

  const ScaleReport* scale_report() const override { return &report_; }

  void WriteChoicesTo(PointChoice* choices) override { choices_ = choices; }

 private:
  absl::Status Sample(size_t group, AutomaticScratch& s) {
    if (table_.empty()) return absl::OkStatus();
    s.pilot.stopped = s.stopped;
    return pilot_.SampleGroup(group, s.pilot, table_);
  }

  // The table, without places for points that were not sampled.
  PilotTable& SampledPoints() {
    std::erase_if(table_, [](const PilotPoint& point) { return !point.is_sampled(); });
    return table_;
  }

  absl::Status MeasureEdges(size_t group, AutomaticScratch& s) {
    s.pilot.stopped = s.stopped;
    s.pilot.most_work = s.most_work;
    s.pilot.first_point = s.first_point;
    s.pilot.rest = 0;
    const absl::Status status = edges_->Measure(group, s.pilot);
    s.rest = s.pilot.rest;
    return status;
  }

  void Choose() {
    SampledPoints();
    if (edges_.has_value()) edges_->Finish(table_);
    choice_ = ChooseScales(table_, BoundsOf(options_, index_));
    if (choices_ != nullptr) ModelErrors();
    Report();
    if (choice_.chosen.empty()) {
      choice_.chosen = {Fallback()};
      choice_.mean.cloud_weights = choice_.gaussian.cloud_weights = {1.0};
    }
    if (edges_.has_value()) edges_->LookAmong(OneSideSearchCount());
    for (const ScaleCandidate& candidate : choice_.chosen) {
      const EstimatorOptions one = OptionsOf(options_, candidate.method, candidate.count());
      runs_.push_back(FindStrategy(one.estimator)->start(one, index_, results_));
      phases_.push_back(std::move(runs_.back()->Phases().front()));
    }
    by_count_.resize(choice_.chosen.size());
    std::iota(by_count_.begin(), by_count_.end(), size_t{0});
    std::stable_sort(by_count_.begin(), by_count_.end(),
                     [this](size_t a, size_t b) { return choice_.chosen[a].rung < choice_.chosen[b].rung; });
  }

  void ModelErrors() {
    std::vector<double> variance_factors;
    for (const ScaleCandidate& candidate : choice_.chosen) {
      variance_factors.push_back(VarianceFactor(options_, candidate));
    }
    if (!choice_.scores.empty()) errors_ = ErrorModel(SampleErrors(table_, choice_, variance_factors));
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
    report_.normal_sigma = NormalNoise(table_, choice_.sigma);
    const auto to_caller = [&](double curvature) { return std::ldexp(curvature, index_.scale_exponent()); };
    for (const ScaleScore& score : choice_.scores) {
      report_.Add({kScaleMethods[score.candidate.method].estimator,
                   FixedCount(options_).value_or(score.candidate.count()), to_caller(score.error),
                   to_caller(score.noise), to_caller(score.bias), score.share});
    }
  }

  // Estimates the group from s.first_point on, as far as all chosen estimators come in a run of their own: what one
  // of them has estimated beyond that is estimated again.
  absl::Status Estimate(size_t group, AutomaticScratch& s) {
    marks_.store(s.seams, std::memory_order_relaxed);
    StartBlends(s);
    size_t done = SpatialIndex::kGroupPoints;
    for (size_t c = 0; c < s.chosen.size(); ++c) {
      // Whatever the smallest neighborhood of a point holds, all of them hold: it alone looks for seams.
      if (absl::Status status = RunChosen(group, c, c == by_count_[0] ? s.seams : nullptr, s); !status.ok()) {
        return status;
      }
      const GroupPoints& points = static_cast<const GroupScratch&>(*s.chosen[c]).points;
      done = std::min(done, points.size);
      if (c == 0) StartWeights(points, s);
      for (size_t i = 0; i < done; ++i) Add(results_[points.slot[i]], i, c, s);
    }
    const GroupPoints& points = static_cast<const GroupScratch&>(*s.chosen.front()).points;
    for (size_t i = 0; i < done; ++i) {
      // An estimate that is not left open is what it is without choices, to the last bit.
      if (!options_.is_automatic()) continue;
      results_[points.slot[i]] = Blended(s, i);
    }
    const absl::Status status = EstimateOneSided(group, done, s);
    for (size_t i = 0; i < done; ++i) ++s.status_counts[static_cast<size_t>(results_[points.slot[i]].status)];
    if (choices_ != nullptr) {
      if (done > 0) s.samples->Start(points.box, ErrorModel::kNearest);
      for (size_t i = 0; i < done; ++i) WriteChoice(points, i, s);
    }
    return status;
  }

  void StartBlends(AutomaticScratch& s) const {
    if (s.chosen.empty()) {
      for (const auto& run : runs_) s.chosen.push_back(run->MakeScratch());
      s.weights.emplace(table_, choice_);
      if (choices_ != nullptr) s.samples.emplace(table_);
    }
    s.blends.fill({});
    s.clear_blends.fill({});
    s.shares.fill({});
    s.rest = 0;
  }

  // Estimates the group, from s.first_point on, as chosen[c] says; s.rest is then that of the shortest run.
  absl::Status RunChosen(size_t group, size_t c, SeamMarks* seams, AutomaticScratch& s) {
    WorkerScratch& one = *s.chosen[c];
    one.stopped = s.stopped;
    one.seams = seams;
    one.most_work = s.most_work / s.chosen.size();
    one.first_point = s.first_point;
    one.rest = 0;
    if (absl::Status status = phases_[c].run(group, one); !status.ok()) return status;
    if (one.rest > 0 && (s.rest == 0 || one.rest < s.rest)) s.rest = one.rest;
    return absl::OkStatus();
  }

  static PointCurvature Blended(const AutomaticScratch& s, size_t i) {
    return IsOneSided(s, i) ? s.blends[i].Finish() : s.clear_blends[i].Finish();
  }

  // Finds out whether there are seams, and smaller neighborhoods to go back to.
  void LookForSeams() {
    const SeamMarks* const marks = marks_.load(std::memory_order_relaxed);
    const bool has_smaller = choice_.chosen[by_count_.front()].rung < choice_.chosen[by_count_.back()].rung;
    // A cloud that is to be rejected needs no results.
    if (marks == nullptr || !has_smaller || options_.opposed_normals == OpposedNormalsPolicy::kReject) return;
    if (marks->ShowSeam()) seams_.emplace(options_, index_, *marks);
  }

  // Averages once more, at the points of the group whose results reach across a seam, the estimates that reach across
  // none. Points without any stay as they are, and are refused by whoever looks at seams.
  absl::Status MendAtSeams(size_t group, AutomaticScratch& s) {
    s.rest = 0;
    if (!seams_.has_value()) return absl::OkStatus();
    const SeamReach::Group found = seams_->ReachingIn(group, results_);
    const size_t first = s.first_point, count = found.size - std::min(first, found.size);
    bool has_any = false;
    for (size_t i = 0; i < count; ++i) {
      s.is_closed[i] = !found.reaches[first + i];
      s.before[i] = results_[found.slots[first + i]];
      has_any = has_any || !s.is_closed[i];
    }
    if (!has_any) return absl::OkStatus();
    StartBlends(s);
    size_t done = count;
    const GroupPoints* points = nullptr;
    for (size_t k = 0; k < by_count_.size(); ++k) {
      const size_t c = by_count_[k];
      if (std::all_of(s.is_closed.begin(), s.is_closed.begin() + static_cast<std::ptrdiff_t>(done),
                      [](bool is_closed) { return is_closed; })) {
        break;
      }
      if (absl::Status status = RunChosen(group, c, nullptr, s); !status.ok()) return status;
      points = &static_cast<const GroupScratch&>(*s.chosen[c]).points;
      done = std::min(done, points->size);
      if (k == 0) StartWeights(*points, s);
      for (size_t i = 0; i < done; ++i) AddShortOfSeams(*points, i, c, s);
    }
    return FinishMended(group, found, done, s);
  }

  // Neighborhoods that are larger than one which reaches across a seam do so as well.
  void AddShortOfSeams(const GroupPoints& points, size_t i, size_t c, AutomaticScratch& s) const {
    if (s.is_closed[i]) return;
    const PointCurvature& estimate = results_[points.slot[i]];
    if (estimate.status == PointStatus::kOk) {
      SeamReach::Query query;
      points.query.Get(i, query.position.data());
      points.normal.Get(i, query.normal.data());
      s.is_closed[i] = seams_->Reaches(query, estimate.radius);
    }
    if (!s.is_closed[i]) Add(estimate, i, c, s);
  }

  // Writes the points that have estimates left; all others get back what they were.
  absl::Status FinishMended(size_t group, const SeamReach::Group& found, size_t done, AutomaticScratch& s) {
    const size_t first = s.first_point, count = found.size - first;
    const auto slot = [&](size_t i) { return found.slots[first + i]; };
    const auto is_mended = [&](size_t i) { return i < done && s.blends[i].weight() > 0.0; };
    for (size_t i = 0; i < count; ++i) results_[slot(i)] = is_mended(i) ? Blended(s, i) : s.before[i];
    const absl::Status status = EstimateOneSided(group, done, s);
    const GroupPoints& points = static_cast<const GroupScratch&>(*s.chosen[by_count_[0]]).points;
    if (choices_ != nullptr && done > 0) s.samples->Start(points.box, ErrorModel::kNearest);
    for (size_t i = 0; i < done; ++i) {
      if (!is_mended(i)) continue;
      // It counts as OK already.
      if (results_[slot(i)].status != PointStatus::kOk) {
        results_[slot(i)] = s.before[i];
      } else if (choices_ != nullptr) {
        WriteChoice(points, i, s);
      }
    }
    return status;
  }

  // Whether what was to count most at a point reaches over an edge.
  static bool IsOneSided(const AutomaticScratch& s, size_t i) {
    return s.clear_blends[i].weight() < kLeastClearShare * s.blends[i].weight();
  }

  absl::Status EstimateOneSided(size_t group, size_t count, AutomaticScratch& s) const {
    bool has_any = false;
    for (size_t i = 0; i < count; ++i) has_any = has_any || IsOneSided(s, i);
    if (!has_any) return absl::OkStatus();
    s.pilot.stopped = s.stopped;
    s.pilot.first_point = s.first_point;
    const double most_radius = ScaleOf(options_).max_radius;
    const float most_in_index = most_radius > 0.0 ? static_cast<float>(std::ldexp(most_radius, index_.scale_exponent()))
                                                  : std::numeric_limits<float>::max();
    return edges_->Repair(
        group, most_in_index, [&](size_t i) { return i < count && IsOneSided(s, i); },
        [&](const float* position) { return ScaleAt(position, *s.weights); },
        [&](size_t slot, const PointCurvature& point) { results_[slot] = point; }, s.pilot);
  }

  // Twice as many as the choice takes: on a straight edge, half of them are on the side of a point.
  uint32_t OneSideSearchCount() const {
    constexpr double kLeastShare = 0.1;
    uint32_t count = ScaleOf(options_).least_count;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      if (choice_.mean.cloud_weights[c] >= kLeastShare) count = std::max(count, choice_.chosen[c].count());
    }
    return std::min({2 * count, kMostOneSideCount, MostSampledCount(options_)});
  }

  // As many neighbors as the choice would take without the edge: the mean over its weights.
  OneSideScale ScaleAt(const float* position, LocalWeights& weights) const {
    const LocalWeights::Weights mean = weights.At(position).mean;
    double logarithms = 0.0, total = 0.0;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      logarithms += mean[c] * std::log(static_cast<double>(choice_.chosen[c].count()));
      total += mean[c];
    }
    double error = std::numeric_limits<double>::infinity();
    for (const ScaleScore& score : choice_.scores) {
      if (score.share > 0.0) error = std::min(error, score.error);
    }
    return {std::min<size_t>(static_cast<size_t>(std::lround(std::exp(logarithms / total))), kMostOneSideCount / 2),
            2.0 * error};
  }

  // REQUIRES: s.samples was started with the points' box.
  void WriteChoice(const GroupPoints& points, size_t i, AutomaticScratch& s) const {
    const PointCurvature& point = results_[points.slot[i]];
    PointChoice& choice = choices_[points.slot[i]];
    choice = UndefinedChoice();
    // Of one side of a neighborhood nothing was sampled.
    if (point.status != PointStatus::kOk || IsOneSided(s, i)) return;
    SetWeights(s.shares[i], choice);
    if (seams_.has_value() && !HasMostWeights(s, i)) return;
    float position[3];
    points.query.Get(i, position);
    const double half_difference = std::ldexp(0.5 * (double{point.k2} - point.k1), -index_.scale_exponent());
    const StandardErrors errors = errors_.At(s.samples->At(position), half_difference);
    choice.mean_error = ToCaller(errors.mean);
    choice.k1_error = ToCaller(errors.k1);
    choice.k2_error = ToCaller(errors.k2);
  }

  static bool HasMostWeights(const AutomaticScratch& s, size_t i) {
    const LocalWeights::Weights& all = s.point_weights[i].mean;
    return s.blends[i].weight() >= kLeastShareWithErrors * std::accumulate(all.begin(), all.end(), 0.0);
  }

  float ToCaller(double curvature) const { return static_cast<float>(std::ldexp(curvature, index_.scale_exponent())); }

  // `shares` are the weights of the estimates that the point has.
  void SetWeights(const LocalWeights::Weights& shares, PointChoice& choice) const {
    const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
    std::array<double, kMethodCount> of_method{};
    double count = 0.0;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      const ScaleCandidate& candidate = choice_.chosen[c];
      of_method[candidate.method] += shares[c] / total;
      count += shares[c] / total * FixedCount(options_).value_or(candidate.count());
    }
    choice.neighbor_count = static_cast<float>(count);
    choice.avg_hexagram_weight = static_cast<float>(of_method[kHexagramMethod]);
    choice.normal_regression_weight = static_cast<float>(of_method[kRegressionMethod]);
    choice.jet_weight = static_cast<float>(of_method[kQuarticMethod] + of_method[kQuadricMethod]);
  }

  void StartWeights(const GroupPoints& points, AutomaticScratch& s) {
    if (points.size == 0) return;
    s.weights->Start(points.box);
    for (size_t i = 0; i < points.size; ++i) {
      float position[3];
      points.query.Get(i, position);
      s.point_weights[i] = s.weights->At(position);
      s.edge_distances[i] = std::numeric_limits<float>::infinity();
      if (edges_.has_value() && edges_->HasEdges()) {
        s.edge_distances[i] = std::ldexp(edges_->DistanceToEdge(position), -index_.scale_exponent());
      }
    }
  }

  void Add(PointCurvature estimate, size_t i, size_t c, AutomaticScratch& s) const {
    const double most_radius = ScaleOf(options_).max_radius;
    const bool is_too_large = estimate.status == PointStatus::kOk && estimate.radius > most_radius;
    if (most_radius > 0.0 && is_too_large) estimate.status = PointStatus::kTooFewNeighbors;
    const double mean_weight = s.point_weights[i].mean[c], gaussian_weight = s.point_weights[i].gaussian[c];
    s.blends[i].Add(estimate, mean_weight, gaussian_weight);
    // Results without curvature count: if there are no others, they tell why.
    const bool is_ok = estimate.status == PointStatus::kOk;
    if (is_ok && !(estimate.radius < s.edge_distances[i])) return;
    s.clear_blends[i].Add(estimate, mean_weight, gaussian_weight);
    if (is_ok) s.shares[i][c] = mean_weight;
  }

  const EstimatorOptions options_;
  const SpatialIndex& index_;
  PointCurvature* const results_;
  const Pilot pilot_;
  std::optional<EdgeRun> edges_;  // unless the estimator or the scale is fixed
  PilotTable table_;
  ScaleChoice choice_;
  ErrorModel errors_;
  PointChoice* choices_ = nullptr;  // null: nobody asks
  ScaleReport report_;
  std::vector<std::unique_ptr<StrategyRun>> runs_;  // of the chosen estimators
  std::vector<GroupPhase> phases_;                  // of each, the only one
  std::vector<size_t> by_count_;                    // places of them, the smallest neighborhood first
  std::atomic<const SeamMarks*> marks_ = nullptr;   // where the chosen estimates mark
  std::optional<SeamReach> seams_;                  // if those show a seam, and something can be mended there
};

size_t MostScratchBytes(const EstimatorOptions& options, size_t point_count) {
  size_t chosen = 0;
  for (size_t m = 0; m < kMethodCount; ++m) {
    if (!IsCandidate(options, m)) continue;
    const EstimatorOptions one = OptionsOf(options, m, MostCount(options));
    chosen = std::max(chosen, FindStrategy(one.estimator)->scratch_bytes(one, point_count));
  }
  // The table that all workers share counts with each: it is small.
  const size_t samples = std::min(Pilot::kMostPoints, point_count);
  const size_t shared = samples * (sizeof(PilotPoint) + (options.returns_choice ? sizeof(ErrorSample) : 0));
  return shared + sizeof(AutomaticScratch) - sizeof(PilotScratch) +
         PilotScratch::MostBytes(PilotOptions(options), point_count) + LocalWeights::MostBytes(Pilot::kMostPoints) +
         (options.returns_choice ? NearestSamples::MostBytes(Pilot::kMostPoints) : 0) +
         ScaleChoice::kMostChosen * (chosen + sizeof(void*));
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
                                 .bytes_per_point = EdgeMarks::kBytesPerPoint,
                                 .scratch_bytes = MostScratchBytes,
                                 .start = Start};

}  // namespace

const Strategy& StrategyFor(const EstimatorOptions& options) {
  return options.is_automatic() || options.returns_choice ? kAutomatic : *FindStrategy(options.estimator);
}

uint32_t LeastPoints(const EstimatorOptions& options) {
  if (const auto count = FixedCount(options)) return *count;
  return std::holds_alternative<AutomaticScale>(options.neighborhood) ? kScaleRungs[0] : 0;
}

}  // namespace curvd
