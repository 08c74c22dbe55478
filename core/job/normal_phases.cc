#include "core/job/normal_phases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "core/base/function_phase.h"
#include "core/job/half_normal_phases.h"
#include "core/normals/trust/surface_probe.h"

namespace curvd {
namespace {

// The share of the area that closed pieces must have where a cloud is taken as thin closed ones, and the certificate
// that they may have.
constexpr double kMostlyClosed = 0.9, kMostOfThin = 0.08;
// Where sides that the pilot's scale makes cannot be trusted, so few neighbors may keep to one sheet, which shows in a
// certificate that is lower by this factor.
constexpr uint32_t kFewNeighbors = 17;
constexpr double kMuchBetter = 0.5;
// So many of both sheets, where fits are made for those (NormalFit::two_sheets).
constexpr uint32_t kRimNeighbors = 24, kMostRimNeighbors = 48;
// The most neighbors that may point to the other side, in the mean. Measured, with an automatic scale: up to 0.25 where
// noise of a spacing and more called for so many neighbors that they reach around the surface, and all sides were
// right; 0.41 to 0.50 where sides of thin parts were wrong. A fixed scale of few neighbors makes 0.39 of plates that
// are one spacing thick, whose sides are right.
constexpr double kMostMixed = 0.25, kMostMixedByWish = 0.4;
// Noise from which on another scale is tried, in units of the spacing. Larger clouds than that are tried only where the
// certificate is in doubt: noise that matters there is seen through.
constexpr double kLeastNoise = 0.2;
constexpr size_t kSmallCloud = 32'768;
// The other scale: half of the neighbors, or so many, or twice as many.
constexpr uint32_t kLeastOfOther = 12;
uint32_t OtherCount(uint32_t count) { return count > kLeastOfOther ? std::max(count / 2, kLeastOfOther) : 2 * count; }

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

size_t NormalBytesPerPoint(const NormalOptions& options) {
  size_t bytes = options.returns_normals ? sizeof(PointNormal) : 0;
  if (options.makes_halves) bytes += 3 * sizeof(float);
  if (options.source == NormalSource::kEstimate) {
    bytes += 3 * sizeof(float) + sizeof(PointStatus) + (options.returns_normals ? 2 * sizeof(float) : 0);
  }
  return bytes + Orientation::BytesPerPoint(options);
}

size_t NormalScratchBytes(const NormalOptions& options, size_t point_count, int thread_count) {
  const size_t threads = static_cast<size_t>(thread_count);
  const bool looks_at_given = options.makes_halves && options.source != NormalSource::kEstimate;
  size_t probe = looks_at_given ? HalfNormalPhases::ScratchBytes(point_count, options.max_neighbor_count, thread_count,
                                                                 options.makes_fits_anew)
                                : 0;
  if (options.source != NormalSource::kEstimate) {
    probe = std::max(probe, SurfaceProbe::ScratchBytes(point_count, options.max_neighbor_count, thread_count));
  }
  if (options.source == NormalSource::kGiven) return probe;
  size_t most = std::max({Orientation::ScratchBytes(options, point_count), LinkProbe::ScratchBytes(point_count),
                          SheetProbe::ScratchBytes(point_count, options.max_neighbor_count)});
  if (options.source == NormalSource::kEstimate) {
    const size_t fit = IsAutomatic(options) ? ScalePilot::ScratchBytes(point_count, options.max_neighbor_count)
                                            : NormalScratch::MostBytes(WantedFit(options), point_count);
    most = std::max(most, fit);
  }
  return std::max({probe, threads * most, Orientation::FieldBytes(options, point_count)}) + SideCheck::kMostBytes;
}

NormalPhases::NormalPhases(const NormalOptions& options, NormalAim aim, const std::array<double, 3>& origin,
                           SpatialIndex& index, int thread_count, PhaseSink add_phase,
                           std::function<absl::Status()> then)
    : options_(options),
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
    if (absl::Status status = quality_.Create(places, options_.returns_normals); !status.ok()) return status;
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
    chosen_.fit = WantedFit(options_);
    return AddFit(chosen_);
  }
  chosen_ = pilot_->Choose();
  pilot_.reset();
  // Of two sheets, what looks like noise may be their distance.
  if (chosen_.noisy_sigma.has_value() && !sheets_.two_sheets) {
    sheets_.noise = std::max(sheets_.noise, std::ldexp(*chosen_.noisy_sigma, index_.scale_exponent()));
  }
  attempt_ = sheets_.two_sheets ? Attempt::kOneSheet : Attempt::kChosen;
  if (!sheets_.two_sheets) return AddFit(chosen_);
  return AddFit(ScaleOf(sheets_.neighbor_count, sheets_.is_mixed));
}

ChosenScale NormalPhases::ScaleOf(uint32_t neighbor_count, bool two_sheets) const {
  ChosenScale scale = chosen_;
  NormalFit& fit = scale.fit;
  fit.two_sheets = two_sheets;
  fit.method = options_.method.value_or(NormalMethod::kJet2);
  const uint32_t least = LeastNeighborCount(fit.method), count = std::max(neighbor_count, least);
  fit.neighborhood = NeighborCount{count};
  const bool may_share = chosen_.fit.shares && JetDegree(fit.method) >= 2;
  fit.shares = may_share && count >= NormalFit::kLeastShared;
  if (two_sheets) fit.noisy_part.reset();
  if (fit.noisy_part.has_value()) {
    // As many times more or fewer as of the others.
    NoisyPart& noisy = *fit.noisy_part;
    const double times = static_cast<double>(count) / std::get<NeighborCount>(chosen_.fit.neighborhood).count;
    const double most = static_cast<double>(std::min<size_t>(fit.max_neighbor_count, index_.point_count()));
    noisy.method = fit.method;
    noisy.neighborhood.count = static_cast<uint32_t>(std::clamp(times * noisy.neighborhood.count, 1.0 * least, most));
    noisy.shares = may_share && noisy.neighborhood.count >= NormalFit::kLeastShared;
  }
  if (sheets_.two_sheets) scale.sigma = std::ldexp(sheets_.noise, -index_.scale_exponent());
  return scale;
}

absl::Status NormalPhases::AddFit(const ChosenScale& scale) {
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
  const NormalReport found = report();
  const bool is_closed = found.closed_area_share >= kMostlyClosed && found.certificate.has_value();
  const double certificate = is_closed ? *found.certificate : kNoCertificate;
  switch (attempt_) {
    case Attempt::kOneSheet:
      if (certificate <= MaxTrustedCertificate(0.0) && !IsRepairedRim(found)) return then_();
      NoteThin(found, certificate);
      return thin_certificate_ < kNoCertificate && !scale_.fit.two_sheets ? TryRims() : ChooseThin();
    case Attempt::kThin:
      NoteThin(found, certificate);
      return TryRims();
    case Attempt::kRims:
      NoteThin(found, certificate);
      return ChooseThin();
    case Attempt::kChosen:
      chosen_certificate_ = found.certificate.value_or(0.0);
      if (found.mixes_sides) return AvoidMixing();
      if (WantsCheck(found)) return Check(Attempt::kOther);
      return WantsFew(found) ? TryFew() : then_();
    case Attempt::kKept:
      if (chosen_certificate_ < kNoCertificate || certificate > MaxTrustedCertificate(0.0) || IsRepairedRim(found)) {
        return Check(Attempt::kOtherThin);
      }
      return then_();
    case Attempt::kOther: {
      TakeCheck();
      NormalReport chosen = report();
      chosen.certificate = chosen_certificate_;
      chosen.neighbor_count = std::get<NeighborCount>(chosen_.fit.neighborhood).count;
      return WantsFew(chosen) ? TryFew() : MakeLast(chosen_);
    }
    case Attempt::kOtherThin:
      TakeCheck();
      fit_report_.turned_share_decides = true;
      fit_report_.most_turned_share = kMostTurnedShareOfThin;
      if (!scale_.fit.two_sheets || certificate >= thin_certificate_) return MakeLast(thin_);
      // The better ones of both stay, and may be right where the others were not.
      if (*fit_report_.turned_share <= kMostTurnedShareOfThin || found.neighbor_count > kMostRimNeighbors)
        return then_();
      thin_ = scale_;
      thin_certificate_ = certificate;
      return Check(Attempt::kOtherThin);
    case Attempt::kFew:
      return certificate <= kMuchBetter * chosen_certificate_ ? then_() : MakeLast(chosen_);
    case Attempt::kLast:
      break;
  }
  return then_();
}

bool NormalPhases::IsTornByRepair() const {
  const NormalReport found = report();
  return may_repair_ && !scale_.fit.two_sheets && found.repaired_count > 0 && *found.torn_share > kMostTornShare;
}

bool NormalPhases::IsRepairedRim(const NormalReport& found) const {
  return scale_.fit.two_sheets && found.repaired_count > 0;
}

void NormalPhases::NoteThin(const NormalReport& found, double certificate) {
  if (certificate > kMaxTrustedCertificate || certificate >= thin_certificate_ || found.mixes_sides) return;
  thin_ = scale_;
  thin_certificate_ = certificate;
}

absl::Status NormalPhases::ChooseThin() {
  const bool has_chosen = chosen_certificate_ < kNoCertificate;
  if (!has_chosen && thin_certificate_ > kMostOfThin) return Try(Attempt::kChosen, chosen_);
  return thin_certificate_ < kNoCertificate ? Try(Attempt::kKept, thin_) : MakeLast(chosen_);
}

absl::Status NormalPhases::AvoidMixing() {
  if (thin_certificate_ < kNoCertificate) return Try(Attempt::kKept, thin_);
  return sheets_.two_sheets ? then_() : Try(Attempt::kThin, ScaleOf(kFewNeighbors, false));
}

absl::Status NormalPhases::TryRims() { return Try(Attempt::kRims, ScaleOf(kRimNeighbors, true)); }

absl::Status NormalPhases::TryFew() { return Try(Attempt::kFew, ScaleOf(kFewNeighbors, false)); }
absl::Status NormalPhases::MakeLast(const ChosenScale& scale) { return Try(Attempt::kLast, scale); }

absl::Status NormalPhases::Try(Attempt attempt, const ChosenScale& scale) {
  attempt_ = attempt;
  return AddFit(scale);
}

absl::Status NormalPhases::Check(Attempt other) {
  side_check_.emplace(index_);
  const uint32_t count = std::get<NeighborCount>(scale_.fit.neighborhood).count;
  const bool two_sheets = scale_.fit.two_sheets;
  // Fewer neighbors may be too few to tell a rim, but too many would be no neighborhood.
  const uint32_t more = 2 * count;
  const bool takes_more = two_sheets && more <= index_.point_count() / 3;
  return Try(other, ScaleOf(takes_more ? more : OtherCount(count), two_sheets));
}

void NormalPhases::TakeCheck() {
  fit_report_.turned_share = side_check_->TurnedShare();
  fit_report_.turned_share_decides = sheets_.evenness > 0.0 && sheets_.evenness <= kMostEvenNoise;
  side_check_.reset();
}

bool NormalPhases::WantsCheck(const NormalReport& found) const {
  const bool is_noisy = sheets_.noise > 0.0 && sheets_.noise >= kLeastNoise * sheets_.spacing;
  return is_noisy && (index_.point_count() <= kSmallCloud || found.is_doubtful());
}

bool NormalPhases::WantsFew(const NormalReport& found) const {
  const bool fits_badly = found.certificate.has_value() && *found.certificate > found.max_trusted_certificate;
  return found.is_doubtful() && fits_badly && found.neighbor_count > kFewNeighbors;
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
