#include "core/estimators/seams/one_sheet.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

// Of the distance. Sheets that lie farther apart than kMostHeight are two whatever the noise; below kLeastHeight they
// are one however exact the points are, since a smooth sheet departs as much from the circles through it.
constexpr double kMostHeight = 0.3;
constexpr double kLeastHeight = 0.01;
// Between the two, heights are those of one sheet if those of neighbors that agree spread as widely.
constexpr double kSpreads = 2.0;

}  // namespace

double SheetHeights::Mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }

double SheetHeights::Spread() const {
  if (count_ == 0) return 0.0;
  const double mean = Mean();
  return std::sqrt(std::max(0.0, squares_ / static_cast<double>(count_) - mean * mean));
}

bool LieOnOneSheet(const SheetHeights& agreeing, const SheetHeights& opposed, double distance) {
  const double most = kLeastHeight * distance + kSpreads * agreeing.Spread();
  return MayLieOnOneSheet(agreeing, opposed, distance) && std::abs(opposed.Mean() - agreeing.Mean()) <= most;
}

bool MayLieOnOneSheet(const SheetHeights& agreeing, const SheetHeights& opposed, double distance) {
  return MayLieOnOneSheet(opposed.Mean() - agreeing.Mean(), distance);
}

bool MayLieOnOneSheet(double height, double distance) { return std::abs(height) <= kMostHeight * distance; }

}  // namespace curvd
