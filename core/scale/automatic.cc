#include "core/scale/automatic.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/estimators/seams/seam_marks.h"
#include "core/estimators/strategies.h"
#include "core/scale/automatic_memory.h"
#include "core/scale/automatic_options.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/chosen/choice_writer.h"
#include "core/scale/chosen/chosen_estimates.h"
#include "core/scale/chosen/seam_mending.h"
#include "core/scale/detail/detail_check.h"
#include "core/scale/detail/own_fits.h"
#include "core/scale/edges/edge_run.h"
#include "core/scale/errors/standard_errors.h"
#include "core/scale/judging/position_noise.h"
#include "core/scale/line_distance.h"
#include "core/scale/parts/cloud_choice.h"
#include "core/scale/parts/cloud_parts.h"
#include "core/scale/pilot/pilot.h"
#include "core/scale/scale_choice.h"
#include "core/scale/scale_report.h"
#include "core/scale/scouting.h"

namespace curvd {
namespace {

// Samples, chooses, then estimates group by group by all chosen estimators and averages. Where there are seams, it
// averages once more, at points whose largest neighborhoods reach across one, those whose neighborhoods do not.
class AutomaticRun final : public StrategyRun {
 public:
  AutomaticRun(const EstimatorOptions& options, const SpatialIndex& index, PointCurvature* results)
      : options_(WithinCloud(options, index.point_count())),
        index_(index),
        results_(results),
        pilot_(index, MostSampledCount(options_)) {
    table_.resize(pilot_.rung_count() > 0 ? pilot_.sample_count() : 0, PilotPoint::None());
    if (MindsEdges(options_)) edges_.emplace(index);
    scouting_.emplace(options_, index, pilot_, table_, edges_.has_value() ? &*edges_ : nullptr);
  }

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<AutomaticScratch>(); }

  std::vector<GroupPhase> Phases() override {
    std::vector<GroupPhase> phases;
    const auto sample = [this](Pilot::Samples which) {
      return [this, which](size_t group, WorkerScratch& scratch) {
        return Sample(group, which, table_, static_cast<AutomaticScratch&>(scratch));
      };
    };
    phases.push_back({"scale", nullptr, sample(Pilot::Samples::kScouts)});
    const auto sample_again_if = [&](std::function<bool()> is_needed) {
      phases.push_back({"scale", nullptr, sample(Pilot::Samples::kScouts), std::move(is_needed)});
    };
    sample_again_if([this] { return scouting_->LooksAgain(); });
    if (edges_.has_value()) {
      phases.push_back({"roughness", nullptr, [this](size_t group, WorkerScratch& scratch) {
                          return MeasureEdges(group, static_cast<AutomaticScratch&>(scratch));
                        }});
      phases.push_back({"edges",
                        [this] {
                          edges_->Sample(PositionNoise(table_).value_or(0.0));
                          return absl::OkStatus();
                        },
                        [this](size_t group, WorkerScratch& scratch) {
                          PilotScratch& s = static_cast<AutomaticScratch&>(scratch).pilot;
                          s.RunWithin(scratch, WorkerScratch::kNoLimit);
                          return edges_->Mark(group, s);
                        }});
      sample_again_if([this] {
        edges_->Finish();
        return scouting_->LooksAgainAtEdges();
      });
    }
    phases.push_back({"scale",
                      [this] {
                        scouting_->SpareOthers();
                        return absl::OkStatus();
                      },
                      sample(Pilot::Samples::kOthers)});
    phases.push_back({"scale",
                      [this] {
                        MakeRoomBetween();
                        return absl::OkStatus();
                      },
                      [this](size_t group, WorkerScratch& scratch) {
                        const std::span<PilotPoint> between = std::span(table_).subspan(between_);
                        return Sample(group, Pilot::Samples::kBetween, between,
                                      static_cast<AutomaticScratch&>(scratch));
                      },
                      [this] { return between_ < table_.size(); }});
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
                          return mending_->Mend(group, static_cast<AutomaticScratch&>(scratch));
                        },
                        [this] { return mending_.has_value(); }});
    }
    return phases;
  }

  size_t bytes() const override {
    return table_.capacity() * sizeof(PilotPoint) + choice_.bytes() +
           (choice_writer_.has_value() ? choice_writer_->bytes() : 0) + (edges_.has_value() ? edges_->bytes() : 0);
  }

  const ScaleReport* scale_report() const override { return &report_; }

  void WriteChoicesTo(PointChoice* choices) override { choices_ = choices; }

 private:
  absl::Status Sample(size_t group, Pilot::Samples which, std::span<PilotPoint> table, AutomaticScratch& s) {
    if (table.empty()) return absl::OkStatus();
    s.pilot.RunWithin(s, WorkerScratch::kNoLimit);
    return pilot_.SampleGroup(group, which, s.pilot, table);
  }

  // Keeps those samples that there are, clear of edges.
  void KeepSamples() {
    std::erase_if(table_, [](const PilotPoint& point) { return !point.is_sampled(); });
    if (edges_.has_value()) edges_->KeepClear(table_);
  }

  // Each part of a cloud gets about as many samples as it would alone, and its border is better known. Where there are
  // edges, the samples that there are have been kept clear of them, which is decided once.
  void MakeRoomBetween() {
    KeepSamples();
    between_ = table_.size();
    if (edges_.has_value() && edges_->HasEdges()) return;
    if (!pilot_.HasBetween() || PartsOf(table_).size() < 2) return;
    table_.resize(between_ + pilot_.sample_count(), PilotPoint::None());
  }

  absl::Status MeasureEdges(size_t group, AutomaticScratch& s) {
    s.pilot.RunWithin(s, s.most_work);
    const absl::Status status = edges_->Measure(group, s.pilot);
    s.rest = s.pilot.rest;
    return status;
  }

  void Choose() {
    KeepSamples();
    DropUndeterminedAcrossLines(BoundsOf(options_, index_), table_);
    std::vector<PartChoice> parts;
    for (const PilotPoints samples : PartsOf(table_)) {
      PartChoice part{samples, ChooseScales(samples, BoundsOf(options_, index_)), PositionsAreExact(samples)};
      if (MayHaveOwnFits(options_)) {
        // Checks are made by the normals in use, whose errors neighbors share where there are half normals.
        const bool is_noise_known = !index_.has_half_normals();
        if (is_noise_known) part.check = FindDetailCheck(samples, part.choice);
        part.near_checks = FindNearChecks(samples, part.choice, ScaleOf(options_).least_count, is_noise_known);
      }
      parts.push_back(std::move(part));
    }
    Report(parts);
    for (PartChoice& part : parts) {
      if (!part.choice.chosen.empty()) continue;
      part.choice.chosen = {Fallback()};
      auto& [mean, traceless, gaussian] = part.choice.weights;
      mean.cloud_weights = traceless.cloud_weights = gaussian.cloud_weights = {1.0};
    }
    choice_ = CloudChoice(std::move(parts));
    if (choices_ != nullptr) choice_writer_.emplace(options_, index_, choice_, results_, choices_);
    own_fits_.emplace(options_, index_, choice_, results_);
    estimates_.emplace(options_, index_, choice_, edges_.has_value() ? &*edges_ : nullptr, results_);
  }

  // Parts that differ much are judged each for itself, unless all points are to have the same weights.
  std::vector<PilotPoints> PartsOf(PilotTable& table) const {
    const size_t second = IsPerPoint(options_) ? SplitIntoParts(table) : table.size();
    const PilotPoints all = table;
    if (second == table.size()) return {all};
    return {all.first(second), all.subspan(second)};
  }

  // What is tried where nothing could be judged: what comes of it has a status.
  ScaleCandidate Fallback() const {
    size_t method = 0;
    while (!IsCandidate(options_, method)) ++method;
    if (const auto count = FixedCount(options_)) return {method, RungNear(*count)};
    size_t rung = 0;
    while (kScaleRungs[rung] < ScaleOf(options_).least_count) ++rung;
    return {method, rung};
  }

  void Report(const std::vector<PartChoice>& parts) {
    const auto to_caller = [&](double curvature) { return std::ldexp(curvature, index_.scale_exponent()); };
    size_t judged = 0;
    for (const PartChoice& part : parts) judged += part.choice.scores.empty() ? 0 : part.samples.size();
    for (const auto& [samples, choice, positions_are_exact, check, near_checks] : parts) {
      ScaleReport part;
      part.sampled_points = static_cast<uint32_t>(samples.size());
      part.sigma = std::ldexp(choice.sigma, -index_.scale_exponent());
      // Half normals are noisier than those in use.
      if (!index_.has_half_normals()) part.normal_sigma = NormalNoise(samples, choice.sigma);
      part.positions_are_exact = positions_are_exact;
      for (const ScaleScore& score : choice.scores) {
        const ScaleMethod& method = kScaleMethods[score.candidate.method];
        part.outcomes.push_back({method.estimator, method.degree,
                                 FixedCount(options_).value_or(score.candidate.count()), to_caller(score.error),
                                 to_caller(score.noise), to_caller(score.bias), score.share});
      }
      report_.AddPart(part, static_cast<double>(samples.size()) / static_cast<double>(std::max<size_t>(judged, 1)));
    }
  }

  absl::Status Estimate(size_t group, AutomaticScratch& s) {
    marks_.store(s.seams, std::memory_order_relaxed);
    if (absl::Status status = estimates_->EstimateGroup(group, s); !status.ok()) return status;
    if (absl::Status status = estimates_->LookForDetail(group, s); !status.ok()) return status;
    const GroupPoints& points = s.points;
    // An estimate that is not left open is what it is without choices, to the last bit.
    if (options_.is_automatic()) {
      for (size_t i = 0; i < points.size; ++i) results_[points.slot[i]] = ChosenEstimates::Blended(s, i);
    }
    absl::Status status = estimates_->EstimateOneSided(group, s);
    if (status.ok()) status = own_fits_->EstimateDetails(group, s);
    for (size_t i = 0; i < points.size; ++i) ++s.status_counts[static_cast<size_t>(results_[points.slot[i]].status)];
    if (choice_writer_.has_value() && points.size > 0) {
      choice_writer_->Start(s);
      for (size_t i = 0; i < points.size; ++i) choice_writer_->Write(i, s);
    }
    return status;
  }

  // Finds out whether there are seams, and smaller neighborhoods to go back to.
  void LookForSeams() {
    const SeamMarks* const marks = marks_.load(std::memory_order_relaxed);
    const OwnFits* const own_fits = MayHaveOwnFits(options_) ? &*own_fits_ : nullptr;
    // A cloud that is to be rejected needs no results.
    if (marks == nullptr || (own_fits == nullptr && !estimates_->HaveSmallerOnes()) ||
        options_.opposed_normals == OpposedNormalsPolicy::kReject) {
      return;
    }
    if (!marks->ShowSeam()) return;
    mending_.emplace(options_, index_, *marks, *estimates_, own_fits,
                     choice_writer_.has_value() ? &*choice_writer_ : nullptr, results_);
  }

  const EstimatorOptions options_;
  const SpatialIndex& index_;
  PointCurvature* const results_;
  Pilot pilot_;
  std::optional<EdgeRun> edges_;  // unless the estimator or the scale is fixed
  PilotTable table_;
  std::optional<Scouting> scouting_;  // which holds references to this run
  size_t between_ = 0;                // where those between other samples begin in the table
  CloudChoice choice_;
  PointChoice* choices_ = nullptr;  // null: nobody asks
  ScaleReport report_;
  std::optional<ChoiceWriter> choice_writer_;
  std::optional<OwnFits> own_fits_;
  std::optional<ChosenEstimates> estimates_;
  std::atomic<const SeamMarks*> marks_ = nullptr;  // where the chosen estimates mark
  std::optional<SeamMending> mending_;             // if those show a seam, and something can be mended there
};

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<AutomaticRun>(options, index, results);
}

constexpr Strategy AutomaticStrategy(size_t bytes_per_point) {
  return {.name = kAutomaticEstimator,
          .wire_name = {},
          .summary = "the estimators and scales that suit the cloud, averaged",
          .options = {},
          .needs_normals = true,
          .bytes_per_point = bytes_per_point,
          .scratch_bytes = AutomaticScratchBytes,
          .shared_bytes = AutomaticSharedBytes,
          .start = Start};
}

constexpr Strategy kAutomatic = AutomaticStrategy(0),
                   kAutomaticMindingEdges = AutomaticStrategy(EdgeMarks::kBytesPerPoint);

}  // namespace

const Strategy& StrategyFor(const EstimatorOptions& options) {
  if (!options.is_automatic() && !options.returns_choice) return *FindStrategy(options.estimator);
  return MindsEdges(options) ? kAutomaticMindingEdges : kAutomatic;
}

bool ComparesNormalsOfHalves(const EstimatorOptions& options) {
  return (options.is_automatic() || options.returns_choice) &&
         options.estimator != kScaleMethods[kQuarticMethod].estimator;
}

uint32_t LeastPoints(const EstimatorOptions& options) {
  if (const auto* scale = std::get_if<AutomaticScale>(&options.neighborhood)) return scale->least_count;
  return FixedCount(options).value_or(0);
}

}  // namespace curvd
