#include "core/scale/judging/growing_bias.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

// A change counts if its square is so many times its standard error.
constexpr double kSignificance = 3.0;
// The one before it, which does not count, is at most its square and so many standard errors.
constexpr double kErrorsBefore = 2.0;
// The bias is at most so many times the first change that counts: where changes do not grow, nobody knows how many
// there were before.
constexpr double kMostPerFirstChange = 1.5;
// Before that, it grows from each scale to the one that it is compared with by no less than that of a smooth surface.
constexpr double kGrowthOfSmooth = 2.0;

}  // namespace

GrowingBias::GrowingBias(const std::array<std::optional<CommonChange>, kRungCount>& changes, size_t step) {
  std::array<double, kRungCount> change{};
  std::array<bool, kRungCount> counts{};
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    if (!changes[rung].has_value()) continue;
    change[rung] = std::sqrt(std::max(changes[rung]->mean, 0.0));
    counts[rung] = changes[rung]->mean > kSignificance * changes[rung]->standard_error;
  }
  size_t first = 0;
  while (first + step < kRungCount && !(counts[first] && counts[first + step])) ++first;
  if (first + step >= kRungCount) return;
  // A bias that grows g times from one to the other changes by g - 1 times itself, and so do its changes.
  double growth = change[first + step] / change[first];
  if (first >= step && changes[first - step].has_value()) {
    const CommonChange& before = *changes[first - step];
    const double most_before = std::sqrt(std::max(before.mean + kErrorsBefore * before.standard_error, 0.0));
    if (most_before > 0.0) growth = std::max(growth, change[first] / most_before);
  }
  const double per_first_change =
      growth > 1.0 ? std::min(1.0 / (growth - 1.0), kMostPerFirstChange) : kMostPerFirstChange;
  const double growth_of_rung =
      std::pow(std::max(kGrowthOfSmooth, 1.0 + 1.0 / per_first_change), 1.0 / static_cast<double>(step));
  bias_[first] = per_first_change * change[first];
  for (size_t rung = first; rung-- > 0;) bias_[rung] = bias_[rung + 1] / growth_of_rung;
  for (size_t rung = first + 1; rung < kRungCount; ++rung) {
    bias_[rung] = rung < first + step ? bias_[rung - 1] * growth_of_rung : bias_[rung - step] + change[rung - step];
  }
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    if (rung < first) {
      per_change_[rung] = per_first_change;
    } else if (change[rung] > 0.0) {
      per_change_[rung] = bias_[rung] / change[rung];
    }
  }
}

}  // namespace curvd
