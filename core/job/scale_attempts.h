// Which scale normals are made by after all, where it is chosen automatically.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/index/spatial_index.h"
#include "core/normals/chosen_fit.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "core/normals/sheet_probe.h"

namespace curvd {

// The share of the area that closed pieces must have where a cloud is taken as thin closed ones.
inline constexpr double kMostlyClosed = 0.9;

// Decides by what comes of one scale which one is next. If neighborhoods hold two sheets (core/normals/sheet_probe.h),
// normals are first made of so few neighbors that most come from one sheet; those stay if they orient to closed
// surfaces whose certificate is as good as that of clean ones. Else the same is tried with rims
// (NormalFit::two_sheets), and the better of both is compared with another scale. Unless that comes to closed surfaces,
// the scale that the pilot chose follows. Where its neighborhoods turn out to hold both sides of the surface
// (core/normals/trust/side_probe.h), the thin scales are tried, or are taken after all. Where positions are noisy, its
// sides are compared with those of another scale. If they cannot be trusted, few neighbors are tried, which stay if
// that is much better; else the pilot's normals are made again.
//
// Usage: make normals by scale(), orient them, call Next with what came of that, until it returns kDone.
class ScaleAttempts {
 public:
  enum class Step : uint8_t {
    kDone,     // the normals of now stay
    kFit,      // normals are to be made by scale()
    kCompare,  // likewise, and their sides to be compared with those of the normals of now
  };

  // `method`: that which the caller asks for, if any. `sheets` and `chosen` are what SheetProbe and NormalPilot found.
  // REQUIRES: chosen.fit is by count; `index` outlives this.
  ScaleAttempts(std::optional<NormalMethod> method, const SheetFinding& sheets, const ChosenFit& chosen,
                const SpatialIndex& index);

  // That which normals are to be made by, or were made by.
  const ChosenFit& scale() const { return scale_; }
  // REQUIRES: normals were made by scale(), and `found` tells what was found; after kCompare, turned_share as well.
  Step Next(const NormalReport& found);
  // Where sides are compared: whether they are those of a thin part.
  bool compares_thin() const { return attempt_ == Attempt::kOtherThin; }

 private:
  // At which scale the normals of now are made; all but kLast may be followed by another attempt.
  enum class Attempt : uint8_t {
    kOneSheet,   // that of the probe, if there are two sheets
    kThin,       // few neighbors
    kRims,       // few neighbors of both sheets
    kChosen,     // that of the pilot
    kKept,       // the best for a thin part, again
    kOther,      // another than kChosen
    kOtherThin,  // another than kKept
    kFew,        // few neighbors, since the sides of kChosen do not fit
    kLast,
  };
  static constexpr double kNoCertificate = std::numeric_limits<double>::infinity();

  // Makes normals by the scale, as this attempt.
  Step Try(Attempt attempt, const ChosenFit& scale);
  Step TryFew();
  Step TryRims();
  // Compares the sides of now with those of another scale, in the attempt `other`.
  Step Compare(Attempt other);
  // Whether a repair chose sides of both sheets, which a low certificate alone does not vouch for.
  bool IsRepairedRim(const NormalReport& found) const;
  // Remembers the scale of now, if it is the best one so far for a thin closed part.
  void NoteThin(const NormalReport& found, double certificate);
  // Goes on with the best one.
  Step ChooseThin();
  // Goes on once the neighborhoods of the pilot's scale were found to hold both sides.
  Step AvoidMixing();
  // Goes on once another scale than that of a thin part has sides.
  Step JudgeThin(const NormalReport& found, double certificate);
  // Whether the sides of the pilot's scale are to be compared with those of another one.
  bool WantsComparison(const NormalReport& found) const;
  // Whether few neighbors are to be tried instead.
  static bool WantsFew(const NormalReport& found);
  // The chosen scale with another number of neighbors, by the method that was asked for or jets of degree 2.
  ChosenFit ScaleOf(uint32_t neighbor_count, bool two_sheets) const;

  const std::optional<NormalMethod> method_;
  const SheetFinding sheets_;
  const ChosenFit chosen_;
  const SpatialIndex& index_;
  Attempt attempt_;
  ChosenFit scale_;  // of the attempt of now
  ChosenFit thin_;   // the best so far for a thin part
  double chosen_certificate_ = kNoCertificate, thin_certificate_ = kNoCertificate;
};

}  // namespace curvd
