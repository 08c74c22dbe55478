#include "core/job/phases/normal_phases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "core/base/function_phase.h"
#include "core/job/phases/half_normal_phases.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/trust/surface_probe.h"

namespace curvd {
namespace {

// The most neighbors that may point to the other side, in the mean. Measured, with an automatic scale: up to 0.25 where
// noise of a spacing and more called for so many neighbors that they reach around the surface, and all sides were
// right; 0.41 to 0.50 where sides of thin parts were wrong. A fixed scale of few neighbors makes 0.39 of plates that
// are one spacing thick, whose sides are right.
constexpr double kMostMixed = 0.25, kMostMixedByWish = 0.4;
bool IsAutomatic(const NormalOptions& options) {
  return std::holds_alternative<AutoNeighborhood>(options.neighborhood);
}

// The fit that options ask for. REQUIRES: it is not automatic.
NormalFit WantedFit(const NormalOptions& options) {
  NormalFit fit;
  fit.method = options.method.value_or(NormalMethod::kJet2);
  fit.max_neighbor_count = options.max_neighbor_count;
  if (const auto* count = std::get_if<NeighborCount>(&options.neighborhood)) fit.neighborhood = *count;
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) fit.neighborhood = *radius;
  return fit;
}

PointNormal Undefined(PointStatus status) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  return {{kNan, kNan, kNan}, kNan, kNan, status};
}

}  // namespace

size_t NormalBytesPerPoint(const NormalOptions& options, const NormalTasks& tasks) {
  size_t bytes = tasks.returns_normals ? sizeof(PointNormal) : 0;
  if (tasks.makes_halves) bytes += 3 * sizeof(float);
  if (options.source == NormalSource::kEstimate) {
    bytes += 3 * sizeof(float) + sizeof(PointStatus) + (tasks.returns_normals ? 2 * sizeof(float) : 0);
  }
  return bytes + Orientation::BytesPerPoint(options);
}

size_t NormalScratchBytes(const NormalOptions& options, const NormalTasks& tasks, size_t point_count,
                          int thread_count) {
  const size_t threads = static_cast<size_t>(thread_count);
  const bool looks_at_given = tasks.makes_halves && options.source != NormalSource::kEstimate;
  size_t probe = looks_at_given ? HalfNormalPhases::ScratchBytes(point_count, options.max_neighbor_count, thread_count,
                                                                 tasks.makes_fits_anew)
                                : 0;
  if (options.source != NormalSource::kEstimate) {
    probe = std::max(probe, SurfaceProbe::ScratchBytes(point_count, options.max_neighbor_count, thread_count));
  }
  if (options.source == NormalSource::kGiven) return probe;
  size_t most = std::max({Orientation::ScratchBytes(options, point_count), LinkProbe::ScratchBytes(point_count),
                          SheetProbe::ScratchBytes(point_count, options.max_neighbor_count)});
  if (options.source == NormalSource::kEstimate) {
    const size_t fit = IsAutomatic(options) ? NormalPilot::ScratchBytes(point_count, options.max_neighbor_count)
                                            : NormalScratch::MostBytes(WantedFit(options), point_count);
    most = std::max(most, fit);
  }
  return std::max({probe, threads * most, Orientation::FieldBytes(options, point_count)}) + SideCheck::kMostBytes;
}

NormalPhases::NormalPhases(const NormalOptions& options, const NormalTasks& tasks, NormalAim aim,
                           const std::array<double, 3>& origin, SpatialIndex& index, int thread_count,
                           PhaseSink add_phase, std::function<absl::Status()> then)
    : options_(options),
      tasks_(tasks),
      aim_(aim),
      index_(index),
      thread_count_(thread_count),
      add_phase_(std::move(add_phase)),
      origin_(origin),
      then_(std::move(then)) {}

absl::Status NormalPhases::Start() {
  if (index_.point_count() == 0) {
    Orient();
    return absl::OkStatus();
  }
  if (options_.source == NormalSource::kEstimate) {
    if (absl::Status status = index_.MakeNormals(); !status.ok()) return status;
    const size_t places = index_.leaf_count() * SpatialIndex::kLeafSize;
    if (absl::Status status = quality_.Create(places, tasks_.returns_normals); !status.ok()) return status;
  }
  AddLooks();
  return absl::OkStatus();
}

std::string_view NormalPhases::LookPhase() const {
  return options_.source == NormalSource::kEstimate ? kNormalsPhase : kOrientationPhase;
}

void NormalPhases::AddLooks() {
  const std::string_view name = LookPhase();
  if (options_.source == NormalSource::kEstimate && IsAutomatic(options_)) {
    pilot_.emplace(index_, options_.method, options_.max_neighbor_count, thread_count_, aim_);
    add_phase_(MakeProbePhase(kNormalsPhase, *pilot_));
  }
  if (std::holds_alternative<ConsistentSides>(options_.sides)) {
    sheet_probe_.emplace(index_, options_.max_neighbor_count, thread_count_);
    add_phase_(MakeProbePhase(name, *sheet_probe_));
  }
  add_phase_(MakeStep(name, [this] {
    if (sheet_probe_.has_value()) sheets_ = sheet_probe_->Find();
    sheet_probe_.reset();
    if (!std::holds_alternative<ConsistentSides>(options_.sides)) return Fit();
    link_probe_.emplace(index_, thread_count_);
    return LookAtLinks();
  }));
}

absl::Status NormalPhases::LookAtLinks() {
  if (link_probe_->AddBlocks()) {
    add_phase_(MakeProbePhase(LookPhase(), *link_probe_));
    add_phase_(MakeStep(LookPhase(), [this] { return LookAtLinks(); }));
    return absl::OkStatus();
  }
  links_per_point_ = link_probe_->LinksPerPoint();
  link_probe_.reset();
  return Fit();
}

absl::Status NormalPhases::Fit() {
  if (options_.source != NormalSource::kEstimate) {
    Orient();
    return absl::OkStatus();
  }
  if (!pilot_.has_value()) {
    ChosenFit wanted;
    wanted.fit = WantedFit(options_);
    return AddFit(wanted);
  }
  const ChosenFit chosen = pilot_->Choose();
  pilot_.reset();
  // Of two sheets, what looks like noise may be their distance.
  if (chosen.noisy_sigma.has_value() && !sheets_.two_sheets) {
    sheets_.noise = std::max(sheets_.noise, std::ldexp(*chosen.noisy_sigma, index_.scale_exponent()));
  }
  attempts_.emplace(options_.method, sheets_, chosen, index_);
  return AddFit(attempts_->scale());
}

absl::Status NormalPhases::AddFit(const ChosenFit& scale) {
  scale_ = scale;
  fit_report_.method = scale_.fit.method;
  fit_report_.sigma = scale_.sigma;
  const auto* count = std::get_if<NeighborCount>(&scale_.fit.neighborhood);
  if (count != nullptr) fit_report_.neighbor_count = count->count;
  fit_report_.noisy_part.reset();
  if (const auto& noisy = scale_.fit.noisy_part) {
    fit_report_.noisy_part = {noisy->method, noisy->neighborhood.count, scale_.noisy_sigma, scale_.noisy_share};
  }
  const size_t least = LeastNeighborCount(scale_.fit.method);
  if (index_.point_count() < (count != nullptr ? std::max<size_t>(count->count, least) : 1)) {
    FillTooFew();
    return EndFit();
  }
  fit_ = StartNormalFit(scale_.fit, index_, quality_);
  scratch_.emplace(*fit_, thread_count_);
  GroupPhase groups = std::move(fit_->Phases().front());
  add_phase_(
      MakeGroupPhase(std::move(groups), index_, GroupsPerBlock(scale_.fit.OptionsForOnePoint()), *scratch_, nullptr));
  add_phase_(MakeStep(kNormalsPhase, [this] { return EndFit(); }));
  return absl::OkStatus();
}

// For a cloud with fewer points than a neighborhood.
void NormalPhases::FillTooFew() {
  const PointSet& set = index_.point_set();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (size_t place = 0; place < index_.point_count(); ++place) {
    SpatialIndex::LeafNormals& normals = index_.mutable_normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    normals.x[lane] = normals.y[lane] = normals.z[lane] = kNan;
    quality_.status[place] = PointStatus::kTooFewNeighbors;
    const int32_t rank = index_.positions(place / SpatialIndex::kLeafSize).id[lane];
    if (set.is_query(rank)) ++fit_report_.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)];
    if (quality_.residual.size() > 0) quality_.residual[place] = quality_.variance_ratio[place] = kNan;
  }
}

absl::Status NormalPhases::EndFit() {
  if (scratch_.has_value()) fit_report_.status_counts = scratch_->status_counts();
  scratch_.reset();
  fit_.reset();
  Orient();
  return absl::OkStatus();
}

void NormalPhases::Orient(bool may_repair) {
  const OrientationHints hints{sheets_.two_sheets, links_per_point_, may_repair};
  orientations_.push_back(std::make_unique<Orientation>(
      index_, options_, origin_, thread_count_, add_phase_, [this] { return EndOrientation(); }, hints));
  may_repair_ = may_repair;
  orientations_.back()->Start();
}

const NormalFit* NormalPhases::fit() const {
  return options_.source == NormalSource::kEstimate && HasFit() ? &scale_.fit : nullptr;
}

bool NormalPhases::HasFit() const {
  const auto* count = std::get_if<NeighborCount>(&scale_.fit.neighborhood);
  return index_.point_count() > 0 && (count == nullptr || count->count <= index_.point_count());
}

absl::Status NormalPhases::EndOrientation() {
  fit_report_.opposed_share.reset();
  fit_report_.torn_share.reset();
  fit_report_.mixes_sides = false;
  if (options_.source != NormalSource::kEstimate || !HasFit() ||
      !std::holds_alternative<ConsistentSides>(options_.sides))
    return Decide();
  side_probe_.emplace(index_, scale_.fit, thread_count_);
  add_phase_(MakeProbePhase(kOrientationPhase, *side_probe_));
  add_phase_(MakeStep(kOrientationPhase, [this] {
    fit_report_.torn_share = side_probe_->TornShare();
    if (!scale_.fit.two_sheets) {
      const double share = side_probe_->OpposedShare();
      fit_report_.opposed_share = share;
      fit_report_.mixes_sides = share > (IsAutomatic(options_) ? kMostMixed : kMostMixedByWish);
    }
    side_probe_.reset();
    if (!IsTornByRepair()) return Decide();
    Orient(false);
    return absl::OkStatus();
  }));
  return absl::OkStatus();
}

absl::Status NormalPhases::Decide() {
  if (!attempts_.has_value()) return then_();
  if (side_check_.has_value()) TakeCheck();
  switch (attempts_->Next(report())) {
    case ScaleAttempts::Step::kDone:
      return then_();
    case ScaleAttempts::Step::kCompare:
      side_check_.emplace(index_);
      break;
    case ScaleAttempts::Step::kFit:
      break;
  }
  return AddFit(attempts_->scale());
}

void NormalPhases::TakeCheck() {
  fit_report_.turned_share = side_check_->TurnedShare();
  fit_report_.turned_share_decides = sheets_.evenness > 0.0 && sheets_.evenness <= kMostEvenNoise;
  if (attempts_->compares_thin()) {
    fit_report_.turned_share_decides = true;
    fit_report_.most_turned_share = kMostTurnedShareOfThin;
  }
  side_check_.reset();
}

bool NormalPhases::IsTornByRepair() const {
  const NormalReport found = report();
  return may_repair_ && !scale_.fit.two_sheets && found.repaired_count > 0 && *found.torn_share > kMostTornShare;
}

PointStatus NormalPhases::status(size_t place) const {
  return quality_.status.size() > 0 ? quality_.status[place] : PointStatus::kOk;
}

NormalReport NormalPhases::report() const {
  NormalReport report = fit_report_;
  if (quality_.status.size() == 0) report.status_counts[static_cast<size_t>(PointStatus::kOk)] = collected_;
  if (!orientations_.empty()) orientations_.back()->Report(report);
  const bool is_consistent = std::holds_alternative<ConsistentSides>(options_.sides);
  report.may_be_closed = is_consistent && options_.source == NormalSource::kEstimate && sheets_.unlike_noise &&
                         report.closed_area_share < kMostlyClosed;
  if (sheets_.spacing > 0.0) report.max_trusted_certificate = MaxTrustedCertificate(sheets_.noise / sheets_.spacing);
  return report;
}

absl::Status NormalPhases::AddCollection(NormalField& field, std::function<absl::Status()> then) {
  constexpr size_t kBlockPoints = 65'536;
  const size_t points = index_.point_count();
  auto created = NormalField::Create(index_.point_set().query_count());
  if (!created.ok()) return created.status();
  field = *std::move(created);
  // The index does not hold points that are not valid.
  const size_t slots = field.size();
  add_phase_(MakeLoop(kOrientationPhase, slots, kBlockPoints, [&field](size_t first, size_t last) {
    std::fill(field.data() + first, field.data() + last, Undefined(PointStatus::kInvalidInput));
  }));
  add_phase_(MakeLoop(
      kOrientationPhase, points, kBlockPoints,
      [this, &field](size_t first, size_t last) { Collect(first, last, field); }, std::move(then)));
  return absl::OkStatus();
}

void NormalPhases::Collect(size_t first, size_t last, NormalField& field) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const PointSet& set = index_.point_set();
  size_t collected = 0;
  for (size_t place = first; place < last; ++place) {
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const int32_t rank = index_.positions(leaf).id[lane];
    if (!set.is_query(rank)) continue;
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    const bool has_quality = quality_.residual.size() > 0;
    field[set.slot_of(rank)] = {{n.x[lane], n.y[lane], n.z[lane]},
                                has_quality ? quality_.residual[place] : kNan,
                                has_quality ? quality_.variance_ratio[place] : kNan,
                                status(place)};
    ++collected;
  }
  collected_ += collected;
}

size_t NormalPhases::bytes() const {
  return quality_.bytes() + (pilot_.has_value() ? pilot_->bytes() : 0) +
         (sheet_probe_.has_value() ? sheet_probe_->bytes() : 0) + (link_probe_.has_value() ? link_probe_->bytes() : 0) +
         (side_check_.has_value() ? side_check_->bytes() : 0) + (side_probe_.has_value() ? side_probe_->bytes() : 0) +
         (orientations_.empty() ? 0 : orientations_.back()->bytes());
}

}  // namespace curvd
