#include "core/job/scale_attempts.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/normals/normal_fit.h"
#include "core/normals/normal_pilot.h"

namespace curvd {
namespace {

// The certificate that thin closed parts may have.
constexpr double kMostOfThin = 0.08;
// Where sides that the pilot's scale makes cannot be trusted, so few neighbors may keep to one sheet, which shows in a
// certificate that is lower by this factor.
constexpr uint32_t kFewNeighbors = 17;
constexpr double kMuchBetter = 0.5;
// So many of both sheets, where fits are made for those (NormalFit::two_sheets).
constexpr uint32_t kRimNeighbors = 24, kMostRimNeighbors = 48;
// Noise from which on another scale is tried, in units of the spacing. Larger clouds than that are tried only where the
// certificate is in doubt: noise that matters there is seen through.
constexpr double kLeastNoise = 0.2;
constexpr size_t kSmallCloud = 32'768;
// The other scale: half of the neighbors, or so many, or twice as many.
constexpr uint32_t kLeastOfOther = 12;
uint32_t OtherCount(uint32_t count) { return count > kLeastOfOther ? std::max(count / 2, kLeastOfOther) : 2 * count; }

uint32_t CountOf(const ChosenFit& scale) { return std::get<NeighborCount>(scale.fit.neighborhood).count; }

}  // namespace

ScaleAttempts::ScaleAttempts(std::optional<NormalMethod> method, const SheetFinding& sheets, const ChosenFit& chosen,
                             const SpatialIndex& index)
    : method_(method),
      sheets_(sheets),
      chosen_(chosen),
      index_(index),
      attempt_(sheets.two_sheets ? Attempt::kOneSheet : Attempt::kChosen),
      scale_(sheets.two_sheets ? ScaleOf(sheets.neighbor_count, sheets.is_mixed) : chosen) {}

ChosenFit ScaleAttempts::ScaleOf(uint32_t neighbor_count, bool two_sheets) const {
  ChosenFit scale = chosen_;
  NormalFit& fit = scale.fit;
  fit.two_sheets = two_sheets;
  fit.method = method_.value_or(NormalMethod::kJet2);
  const uint32_t least = LeastNeighborCount(fit.method), count = std::max(neighbor_count, least);
  fit.neighborhood = NeighborCount{count};
  const bool may_share = chosen_.fit.shares && JetDegree(fit.method) >= 2;
  fit.shares = may_share && count >= NormalFit::kLeastShared;
  if (two_sheets) fit.noisy_part.reset();
  if (fit.noisy_part.has_value()) {
    // As many times more or fewer as of the others.
    NoisyPart& noisy = *fit.noisy_part;
    const double times = static_cast<double>(count) / CountOf(chosen_);
    const double most = static_cast<double>(
        std::min<size_t>({fit.max_neighbor_count, index_.point_count(), NormalPilot::kMostNeighbors}));
    noisy.method = fit.method;
    noisy.neighborhood.count = static_cast<uint32_t>(std::clamp(times * noisy.neighborhood.count, 1.0 * least, most));
    noisy.shares = may_share && noisy.neighborhood.count >= NormalFit::kLeastShared;
  }
  const bool has_fewer = fit.edge_part.has_value() && 2 * fit.edge_part->neighborhood.count <= count;
  if (two_sheets || !has_fewer) fit.edge_part.reset();
  if (sheets_.two_sheets) scale.sigma = std::ldexp(sheets_.noise, -index_.scale_exponent());
  return scale;
}

ScaleAttempts::Step ScaleAttempts::Next(const NormalReport& found) {
  const bool is_closed = found.closed_area_share >= kMostlyClosed && found.certificate.has_value();
  const double certificate = is_closed ? *found.certificate : kNoCertificate;
  switch (attempt_) {
    case Attempt::kOneSheet:
      if (certificate <= MaxTrustedCertificate(0.0) && !IsRepairedRim(found)) return Step::kDone;
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
      if (WantsComparison(found)) return Compare(Attempt::kOther);
      return WantsFew(found) ? TryFew() : Step::kDone;
    case Attempt::kKept:
      if (chosen_certificate_ < kNoCertificate || certificate > MaxTrustedCertificate(0.0) || IsRepairedRim(found)) {
        return Compare(Attempt::kOtherThin);
      }
      return Step::kDone;
    case Attempt::kOther: {
      NormalReport chosen = found;
      chosen.certificate = chosen_certificate_;
      chosen.neighbor_count = CountOf(chosen_);
      return WantsFew(chosen) ? TryFew() : Try(Attempt::kLast, chosen_);
    }
    case Attempt::kOtherThin:
      return JudgeThin(found, certificate);
    case Attempt::kFew:
      return certificate <= kMuchBetter * chosen_certificate_ ? Step::kDone : Try(Attempt::kLast, chosen_);
    case Attempt::kLast:
      break;
  }
  return Step::kDone;
}

bool ScaleAttempts::IsRepairedRim(const NormalReport& found) const {
  return scale_.fit.two_sheets && found.repaired_count > 0;
}

void ScaleAttempts::NoteThin(const NormalReport& found, double certificate) {
  if (certificate > kMaxTrustedCertificate || certificate >= thin_certificate_ || found.mixes_sides) return;
  thin_ = scale_;
  thin_certificate_ = certificate;
}

ScaleAttempts::Step ScaleAttempts::ChooseThin() {
  const bool has_chosen = chosen_certificate_ < kNoCertificate;
  if (!has_chosen && thin_certificate_ > kMostOfThin) return Try(Attempt::kChosen, chosen_);
  return thin_certificate_ < kNoCertificate ? Try(Attempt::kKept, thin_) : Try(Attempt::kLast, chosen_);
}

ScaleAttempts::Step ScaleAttempts::AvoidMixing() {
  if (thin_certificate_ < kNoCertificate) return Try(Attempt::kKept, thin_);
  return sheets_.two_sheets ? Step::kDone : Try(Attempt::kThin, ScaleOf(kFewNeighbors, false));
}

ScaleAttempts::Step ScaleAttempts::JudgeThin(const NormalReport& found, double certificate) {
  if (!scale_.fit.two_sheets || certificate >= thin_certificate_) return Try(Attempt::kLast, thin_);
  // The better ones of both stay, and may be right where the others were not.
  if (*found.turned_share <= kMostTurnedShareOfThin || found.neighbor_count > kMostRimNeighbors) return Step::kDone;
  thin_ = scale_;
  thin_certificate_ = certificate;
  return Compare(Attempt::kOtherThin);
}

ScaleAttempts::Step ScaleAttempts::TryRims() { return Try(Attempt::kRims, ScaleOf(kRimNeighbors, true)); }

ScaleAttempts::Step ScaleAttempts::TryFew() { return Try(Attempt::kFew, ScaleOf(kFewNeighbors, false)); }

ScaleAttempts::Step ScaleAttempts::Try(Attempt attempt, const ChosenFit& scale) {
  attempt_ = attempt;
  scale_ = scale;
  return Step::kFit;
}

ScaleAttempts::Step ScaleAttempts::Compare(Attempt other) {
  const bool two_sheets = scale_.fit.two_sheets;
  // Fewer neighbors may be too few to tell a rim, but too many would be no neighborhood.
  const uint32_t count = CountOf(scale_), more = 2 * count;
  const bool takes_more = two_sheets && more <= index_.point_count() / 3;
  Try(other, ScaleOf(takes_more ? more : OtherCount(count), two_sheets));
  return Step::kCompare;
}

bool ScaleAttempts::WantsComparison(const NormalReport& found) const {
  const bool is_noisy = sheets_.noise > 0.0 && sheets_.noise >= kLeastNoise * sheets_.spacing;
  return is_noisy && (index_.point_count() <= kSmallCloud || found.is_doubtful());
}

bool ScaleAttempts::WantsFew(const NormalReport& found) {
  const bool fits_badly = found.certificate.has_value() && *found.certificate > found.max_trusted_certificate;
  return found.is_doubtful() && fits_badly && found.neighbor_count > kFewNeighbors;
}

}  // namespace curvd
