#include "core/job/curvature_job.h"

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/function_phase.h"
#include "core/base/out_of_memory.h"
#include "core/base/stop_sign.h"
#include "core/estimators/seams/agreement_run.h"
#include "core/index/index_builder.h"
#include "core/index/spatial_index.h"
#include "core/job/phased_job.h"
#include "core/job/phases/cloud_normals.h"
#include "core/job/phases/group_phase.h"
#include "core/job/phases/index_phases.h"
#include "core/job/phases/normal_phases.h"
#include "core/job/phases/seam_phase.h"
#include "core/job/scale_fields.h"
#include "core/scale/automatic.h"

namespace curvd {
namespace {

// The phases of an estimate in order: the index's; those of normals that do not stay as they came; the field, with the
// points that the index does not hold; the strategy's; the seams; the outliers, if they are looked for; how far the
// normals agree, if there are seams.
class PhasedCurvatureJob final : public CurvatureJob, public PhasedJob {
 public:
  PhasedCurvatureJob(Cloud cloud, const std::array<double, 3>& origin, const std::optional<EstimatorOptions>& options,
                     const NormalOptions& normal_options, const JobPlace& place, OutlierSearch search)
      : PhasedJob(place.pool, place.priority, place.caller),
        wants_curvature_(options.has_value()),
        search_(SearchIn(cloud, options, search)),
        rejects_seams_at_end_(search_ != OutlierSearch::kNone &&
                              options->opposed_normals == OpposedNormalsPolicy::kReject),
        options_(OptionsOf(options, rejects_seams_at_end_)),
        normal_options_(normal_options),
        size_(cloud.size()),
        origin_(origin),
        query_count_(cloud.point_set().query_count()),
        invalid_count_(cloud.invalid_query_count()),
        builder_(std::in_place, std::move(cloud), StopSign(&stopped())),
        fields_(options_),
        thread_count_(place.pool.thread_count()) {}

  void Start(Callback callback) override {
    callback_ = std::move(callback);
    Run(CatchBadAlloc([this] {
      AddPhase(MakeStep(kIndexPhase, [this] { return StartIndex(); }));
      AddPhase(MakeCollectPhase(*builder_));
      AddPhase(MakeCollectPhase(*builder_));
      AddPhase(MakeTreePhase(*builder_));
      AddPhase(MakeStep(kIndexPhase, [this] { return AddNormals(); }));
      return absl::OkStatus();
    }));
  }

  std::optional<OutlierPhases::Rest> TakeRest() override { return std::exchange(rest_, std::nullopt); }

  void Cancel() override { PhasedJob::Cancel(); }

  JobProgress progress() const override {
    JobProgress progress;
    progress.points_estimated = points_estimated_;
    VisitPhaseTimes([&progress](const PhaseTime& phase) {
      JobSeconds& seconds = progress.seconds;
      if (phase.name == kQueuePhase) {
        progress.phase = JobPhase::kQueued;
        seconds.queue = phase.seconds;
      } else if (phase.name == kIndexPhase) {
        progress.phase = JobPhase::kIndexing;
        seconds.index = phase.seconds;
      } else if (phase.name == kNormalsPhase) {
        progress.phase = JobPhase::kMakingNormals;
        seconds.normals = seconds.normals.value_or(0.0) + phase.seconds;
      } else if (phase.name == kOrientationPhase) {
        progress.phase = JobPhase::kOrienting;
        seconds.orientation = seconds.orientation.value_or(0.0) + phase.seconds;
      } else {
        progress.phase = JobPhase::kEstimating;
        seconds.estimate = seconds.estimate.value_or(0.0) + phase.seconds;
      }
    });
    if (ended()) progress.phase = JobPhase::kDone;
    return progress;
  }

 private:
  // Whoever sends a part of a cloud does not know what the rest of it explains.
  static OutlierSearch SearchIn(const Cloud& cloud, const std::optional<EstimatorOptions>& options,
                                OutlierSearch search) {
    const bool is_part = cloud.point_set().has_ids() || cloud.point_set().has_roles();
    return options.has_value() && LooksForOutliers(*options) && !is_part ? search : OutlierSearch::kNone;
  }

  // Outliers with opposed normals are no seam: where some are looked for, seams are refused once none is left.
  static EstimatorOptions OptionsOf(const std::optional<EstimatorOptions>& options, bool rejects_seams_at_end) {
    EstimatorOptions of = options.value_or(EstimatorOptions());
    if (rejects_seams_at_end) of.opposed_normals = OpposedNormalsPolicy::kMark;
    return of;
  }

  // Checks the options and takes the memory of the index.
  absl::Status StartIndex() {
    absl::Status status = options_.Validate();
    if (status.ok()) status = normal_options_.Validate(size_);
    return status.ok() ? builder_->Start() : status;
  }

  // Takes the index, and adds the phases of normals, which those of the field follow.
  absl::Status AddNormals() {
    index_ = builder_->Take();
    builder_.reset();  // the index holds all that is needed
    if (search_ != OutlierSearch::kNone) index_.set_keeps_given_normals();
    const auto estimate = wants_curvature_ ? std::optional(options_) : std::nullopt;
    normals_.emplace(estimate, normal_options_, origin_, index_, thread_count_, Sink(), [this] { return AddField(); });
    return normals_->Start();
  }

  // Adds what other classes make phases of.
  PhaseSink Sink() {
    return [this](auto phase) { AddPhase(std::move(phase)); };
  }

  absl::Status AddField() {
    if (!wants_curvature_) return absl::OkStatus();
    AddPhase(std::make_unique<FunctionPhase>(
        kFieldPhase, PhaseFunctions{.begin = [this] { return MakeField(); },
                                    .run = [this](const BlockContext& context) { return FillField(context.block); },
                                    .end = [this] { return AddStrategy(); }}));
    return absl::OkStatus();
  }

  // Takes the results of points without a normal back, once the strategy has run, at the scales from this one on: those
  // before it were refused as a whole.
  absl::Status RefuseWithoutNormal(size_t scale) {
    const PointSet& set = index_.point_set();
    for (size_t place = 0; place < index_.point_count(); ++place) {
      const PointStatus status = normals_->status(place);
      if (status == PointStatus::kOk) continue;
      const int32_t rank = index_.positions(place / SpatialIndex::kLeafSize).id[place % SpatialIndex::kLeafSize];
      // The counts of the scratch, which have the other status, are added at the end.
      if (set.is_query(rank)) fields_.Refuse(scale, set.slot_of(rank), status, status_counts_);
    }
    return absl::OkStatus();
  }

  // Makes the field, and returns in how many blocks points that no estimate reaches are looked for.
  absl::StatusOr<size_t> MakeField() {
    if (absl::Status status = fields_.Allocate(query_count_); !status.ok()) return status;
    if (options_.returns_choice) {
      auto choices = ChoiceField::Create(query_count_);
      if (!choices.ok()) return choices.status();
      choices_ = *std::move(choices);
    }
    status_counts_[static_cast<size_t>(PointStatus::kInvalidInput)] = invalid_count_ * fields_.count();
    return invalid_count_ == 0 ? 0 : (query_count_ + kFillPoints - 1) / kFillPoints;
  }

  // Points that the index holds are written again.
  absl::Status FillField(size_t block) {
    const size_t first = block * kFillPoints;
    fields_.Fill(first, first + kFillPoints, PointStatus::kInvalidInput);
    return absl::OkStatus();
  }

  absl::Status AddStrategy() {
    if (index_.point_count() == 0) return AddChoices();
    const Strategy& strategy = StrategyFor(options_);
    if (strategy.needs_normals && !index_.has_normals()) {
      return MakeCoreError(ErrorKind::kInvalid, absl::StrCat("the cloud has no normals, which the estimator ",
                                                             std::string(strategy.name), " needs"));
    }
    const size_t first = fields_.FirstServed(index_.point_count());
    for (size_t scale = 0; scale < first; ++scale) {
      fields_.RefuseAll(scale, index_);
      status_counts_[static_cast<size_t>(PointStatus::kTooFewNeighbors)] += query_count_ - invalid_count_;
    }
    if (first == fields_.count()) return AddChoices();
    if (normals_->LacksSome()) index_.set_lacks_normals();
    if (absl::Status status = fields_.MakeMarks(first, index_); !status.ok()) return status;
    const EstimatorOptions served = options_.FromScale(first);
    run_ = served.scale_count() == 1 ? strategy.start(served, index_, fields_.points(first).data())
                                     : strategy.start_scales(served, index_, fields_.Places(first));
    run_->WriteChoicesTo(choices_.data());
    scratch_.emplace(*run_, thread_count_, &fields_.marks(first));
    std::vector<GroupPhase> phases = run_->Phases();
    for (size_t i = 0; i < phases.size(); ++i) {
      // Points count where they are estimated, and not where those beside seams are estimated again.
      const bool is_last = phases[i].name != kSeamPhase && (i + 1 == phases.size() || phases[i + 1].name == kSeamPhase);
      AddPhase(MakeGroupPhase(std::move(phases[i]), index_, GroupsPerBlock(options_), *scratch_,
                              is_last ? &points_estimated_ : nullptr));
    }
    if (index_.lacks_normals()) AddPhase(MakeStep(kFieldPhase, [this, first] { return RefuseWithoutNormal(first); }));
    for (size_t scale = first; scale < fields_.count(); ++scale) {
      PointCurvature* const points = fields_.points(scale).data();
      AddPhase(MakeSeamPhase({fields_.options(scale), index_, fields_.marks(scale), points, refused_}));
    }
    AddPhase(MakeStep(kSeamPhase, [this] { return EndStrategy(); }));
    return absl::OkStatus();
  }

  // Takes what the workers have counted and chosen, and adds the phases that look for outliers.
  absl::Status EndStrategy() {
    const auto counts = scratch_->status_counts();
    for (int i = 0; i < kPointStatusEnd; ++i) status_counts_[i] += counts[i];
    if (const ScaleReport* scale = run_->scale_report()) {
      scale_report_ = *scale;
      scale_report_->fitted_normals = normals_->given_made_by();
      scale_report_->normals_made_anew = normals_->made_anew_by();
    }
    shares_errors_ = NeighborsShareErrors();
    if (shares_errors_) scale_report_->normal_sigma.reset();
    scratch_.reset();
    run_.reset();
    if (search_ == OutlierSearch::kNone || index_.point_count() < OutlierRun::kFewestPoints) return AddLast();
    const bool has_own_normals = normal_options_.source != NormalSource::kEstimate;
    outliers_.emplace(index_, size_, has_own_normals, search_, thread_count_, Sink());
    outliers_->Start(
        fields_.points(0).data(), [this] { return AddLast(); }, [this] { FreeResults(); });
    return absl::OkStatus();
  }

  // Adds the phases that follow the look for outliers, where there are none.
  absl::Status AddLast() {
    if (rejects_seams_at_end_ && fields_.ShownSeam() != nullptr) return RefusalOf(*fields_.ShownSeam(), index_);
    absl::Status status = AddChoices();
    return status.ok() ? AddAgreement() : status;
  }

  void FreeResults() {
    fields_.Free();
    choices_ = ChoiceField();
    if (normals_.has_value()) normals_->field() = NormalField();
  }

  absl::Status AddChoices() {
    if (!options_.returns_choice) return absl::OkStatus();
    AddPhase(MakeLoop(kFieldPhase, choices_.size(), kFillPoints,
                      [this](size_t first, size_t last) { TakeChoicesBack(first, last); }));
    return absl::OkStatus();
  }

  // Takes back how the estimate was chosen where there is none.
  void TakeChoicesBack(size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      PointChoice& choice = choices_[i];
      if (fields_.points(0)[i].status != PointStatus::kOk) choice = UndefinedChoice();
      if (!shares_errors_ || ReadsPositions(choice)) continue;
      choice.mean_error = choice.k1_error = choice.k2_error = UndefinedChoice().mean_error;
    }
  }

  // Whether neighbors may share errors of their normals that the sample of the cloud takes for detail: those of normals
  // that were made of noisy positions, by whomever, unless there are normals of halves.
  bool NeighborsShareErrors() const {
    const bool are_fitted = normal_options_.source == NormalSource::kEstimate ||
                            normals_->given_made_by().has_value() || normals_->made_anew_by().has_value();
    if (!are_fitted || index_.has_half_normals()) return false;
    return scale_report_.has_value() && !scale_report_->positions_are_exact;
  }

  // Whether the estimate is that of jets, which read positions alone.
  static bool ReadsPositions(const PointChoice& choice) {
    constexpr float kRounding = 1e-5f;  // of the sum of weights
    return choice.jet_weight > 1.0f - kRounding;
  }

  // Adds the phases that count more where there are seams.
  absl::Status AddAgreement() {
    shown_seam_ = fields_.ShownSeam();
    if (shown_seam_ == nullptr) return absl::OkStatus();
    agreement_run_.emplace(index_, *shown_seam_);
    scratch_.emplace(*agreement_run_, thread_count_);
    for (GroupPhase& phase : agreement_run_->Phases()) {
      AddPhase(MakeGroupPhase(std::move(phase), index_, GroupsPerBlock({}), *scratch_, nullptr));
    }
    return absl::OkStatus();
  }

  NormalsAgreement Agreement() const {
    if (!agreement_run_.has_value()) return {};
    NormalsAgreement agreement = agreement_run_->agreement();
    agreement.seam_points = shown_seam_->SurePoints();
    return agreement;
  }

  size_t HeldBytes() const override {
    return (builder_.has_value() ? builder_->bytes() : 0) + index_.bytes() +
           (normals_.has_value() ? normals_->bytes() : 0) + fields_.bytes() + choices_.bytes() +
           (run_ != nullptr ? run_->bytes() : 0) + (outliers_.has_value() ? outliers_->bytes() : 0) +
           (agreement_run_.has_value() ? agreement_run_->bytes() : 0);
  }

  void OnEnd(absl::Status status) override {
    Callback callback = std::move(callback_);
    const NormalsAgreement agreement = Agreement();
    // Gone before the callback: what it needs memory for may be an error that says that there was none.
    scratch_.reset();
    agreement_run_.reset();
    if (status.ok() && outliers_.has_value()) rest_ = outliers_->TakeRest();
    outliers_.reset();
    run_.reset();
    std::optional<NormalReport> report;
    NormalField normal_field;
    if (status.ok() && !rest_.has_value()) {
      report = normals_->report();
      normal_field = std::move(normals_->field());
      if (!wants_curvature_) {
        status_counts_ = report->status_counts;
        status_counts_[static_cast<size_t>(PointStatus::kInvalidInput)] += invalid_count_;
      }
      if (normal_options_.source == NormalSource::kGiven) report.reset();
    }
    const std::optional<NormalsOffSurface> off_surface = normals_.has_value() ? normals_->off_surface() : std::nullopt;
    normals_.reset();
    builder_.reset();
    fields_.FreeMarks();
    index_ = SpatialIndex();
    uint64_t& opposed = status_counts_[static_cast<size_t>(PointStatus::kOpposedNormals)];
    for (int i = 0; i < kPointStatusEnd; ++i) {
      status_counts_[i] -= refused_[i];
      opposed += refused_[i];
    }
    absl::StatusOr<EstimationResult> result = CatchBadAlloc([&]() -> absl::StatusOr<EstimationResult> {
      if (!status.ok()) return std::move(status);
      if (rest_.has_value()) return EstimationResult{.field = {}, .agreement = {}, .cost = Cost()};
      std::vector<PageArray<PointCurvature>> smaller(fields_.count() - 1);
      for (size_t scale = 1; scale < fields_.count(); ++scale) smaller[scale - 1] = std::move(fields_.points(scale));
      return EstimationResult{.field = {std::move(fields_.points(0)), status_counts_},
                              .agreement = agreement,
                              .cost = Cost(),
                              .off_surface = off_surface,
                              .normal_report = report,
                              .normals = std::move(normal_field),
                              .scale_report = std::move(scale_report_),
                              .choices = std::move(choices_),
                              .smaller = std::move(smaller)};
    });
    if (!result.ok()) {
      FreeResults();
      rest_.reset();
    }
    callback(std::move(result));
  }

  JobCost Cost() const { return {progress().seconds, phase_times(), peak_bytes()}; }

  static constexpr size_t kFillPoints = 100'000;  // a few milliseconds, most of them for the system's fresh pages

  const bool wants_curvature_;
  const OutlierSearch search_;
  const bool rejects_seams_at_end_;
  const EstimatorOptions options_;
  const NormalOptions normal_options_;
  Callback callback_;
  const size_t size_;  // of the cloud
  const std::array<double, 3> origin_;
  const size_t query_count_;
  const size_t invalid_count_;
  std::optional<IndexBuilder> builder_;
  SpatialIndex index_;
  std::optional<CloudNormals> normals_;  // from the index on
  ScaleFields fields_;
  std::array<uint64_t, kPointStatusEnd> status_counts_{};  // over all scales
  ChoiceField choices_;                                    // none unless they are asked for
  const int thread_count_;
  const SeamMarks* shown_seam_ = nullptr;  // of fields_, once the estimate is done
  std::array<std::atomic<uint64_t>, kPointStatusEnd> refused_{};
  std::unique_ptr<StrategyRun> run_;
  std::optional<OutlierPhases> outliers_;
  std::optional<OutlierPhases::Rest> rest_;  // once the job has ended
  std::optional<AgreementRun> agreement_run_;
  std::optional<ScaleReport> scale_report_;
  bool shares_errors_ = false;         // NeighborsShareErrors, once the strategy has run
  std::optional<ScratchSet> scratch_;  // of run_, then of agreement_run_
  std::atomic<size_t> points_estimated_ = 0;
};

}  // namespace

std::shared_ptr<CurvatureJob> CurvatureJob::Make(Cloud cloud, const std::array<double, 3>& origin,
                                                 const std::optional<EstimatorOptions>& options,
                                                 const NormalOptions& normals, const JobPlace& place,
                                                 OutlierSearch search) {
  return std::make_shared<PhasedCurvatureJob>(std::move(cloud), origin, options, normals, place, search);
}

}  // namespace curvd
