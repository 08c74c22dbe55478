#include "core/scale/parts/cloud_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace curvd {
namespace {

// The rung whose fits tell noise and density: the smallest with many more neighbors than coefficients.
constexpr size_t kRung = 4;
// That of four times as many neighbors, which tells noise from detail.
constexpr size_t kLargeRung = kRungsThatTellNoise - 1;
static_assert(kScaleRungs[kLargeRung] == 4 * kScaleRungs[kRung]);
// So many times more noise, or larger neighborhoods, make another part.
constexpr double kLeastRatio = 2.0;
// Of the samples of a part, so many may lie between: at its border, neighborhoods have points of both.
constexpr double kBetween = 0.1;
// Parts with fewer samples than these, or than this share of all, but for those between, are not told apart.
constexpr size_t kLeastSamples = 24;
constexpr double kLeastShare = 0.05;
// So many samples may have no fit. They count to the second part.
constexpr double kMostWithoutFit = 0.05;
// Of the samples that lie nearest to one of a part, this share belongs to it in the mean.
constexpr size_t kLike = 6;
constexpr double kLeastLike = 0.6;
// Of the samples of a noisy part, so many show noise.
constexpr double kLeastNoisy = 0.8;
// Noise of less than this part of a neighborhood's radius is rounding.
constexpr double kRounding = 0x1p-22;

// What parts may differ by: logarithms of the noise of the positions, of the normals, and of the distance of points.
enum class Trait : uint8_t { kPositionNoise, kNormalNoise, kSpacing };

double ValueOf(const PilotPoint& point, Trait trait) {
  const double radius = point.radius[kRung];
  double value = radius;
  if (trait == Trait::kPositionNoise) value = std::max<double>(point.residual[kRung], kRounding * radius);
  if (trait == Trait::kNormalNoise) value = std::max<double>(point.normal_residual[kRung], kRounding);
  return std::isfinite(value) && value > 0.0 ? std::log(value) : std::numeric_limits<double>::infinity();
}

// Whether what a fit leaves is noise. Detail grows much faster with the neighborhood; what is below this part of the
// radius, or of a normal's length, is rounding.
bool IsNoise(float small, float large, float length) {
  constexpr float kMostGrowth = 4.0f, kLeast = 0x1p-12f;
  return small > kLeast * length && small * kMostGrowth >= large;
}

bool ShowsNoise(const PilotPoint& point, Trait trait) {
  return trait == Trait::kPositionNoise
             ? IsNoise(point.residual[kRung], point.residual[kLargeRung], point.radius[kRung])
             : IsNoise(point.normal_residual[kRung], point.normal_residual[kLargeRung], 1.0f);
}

struct Split {
  Trait trait;
  double ratio;  // of what the parts differ by, its logarithm
  double from;   // the second part has larger values than this

  bool IsSecond(const PilotPoint& point) const { return ValueOf(point, trait) >= from; }
};

// Where the values fall apart the farthest; nothing if that is nowhere far enough.
std::optional<Split> SplitBy(Trait trait, PilotPoints samples) {
  std::vector<double> sorted;
  for (const PilotPoint& point : samples) sorted.push_back(ValueOf(point, trait));
  std::sort(sorted.begin(), sorted.end());
  const auto share_of = [](double share, size_t count) {
    return static_cast<size_t>(share * static_cast<double>(count));
  };
  const size_t size = sorted.size(), least = std::max(kLeastSamples, share_of(kLeastShare, size));
  if (!std::isfinite(sorted[size - 1 - share_of(kMostWithoutFit, size)])) return std::nullopt;
  std::optional<Split> best;
  for (size_t first = least; first + least <= size; ++first) {
    const double low = sorted[first - 1 - share_of(kBetween, first)];
    const double high = sorted[first + share_of(kBetween, size - first)];
    const double least_ratio = best.has_value() ? best->ratio : std::log(kLeastRatio);
    if (std::isfinite(high) && high - low > least_ratio) best = Split{trait, high - low, 0.5 * (low + high)};
  }
  return best;
}

// Whether the second part is one of noise, or of larger distances, and not of more detail.
bool IsOfItsKind(PilotPoints samples, const Split& split) {
  if (split.trait == Trait::kSpacing) return true;
  size_t second = 0, noisy = 0;
  for (const PilotPoint& point : samples) {
    if (!split.IsSecond(point)) continue;
    ++second;
    noisy += ShowsNoise(point, split.trait) ? 1 : 0;
  }
  return static_cast<double>(noisy) >= kLeastNoisy * static_cast<double>(second);
}

// Whether the samples of each part lie among their like.
bool LieTogether(PilotPoints samples, const Split& split) {
  std::vector<bool> is_second;
  for (const PilotPoint& point : samples) is_second.push_back(split.IsSecond(point));
  NearestSamples nearest(samples);
  std::array<double, 2> like{}, all{};
  for (size_t i = 0; i < samples.size(); ++i) {
    nearest.Start({samples[i].position, samples[i].position}, kLike + 1);  // itself is one
    for (const uint32_t j : nearest.At(samples[i].position.data())) {
      like[is_second[i] ? 1 : 0] += j != i && is_second[j] == is_second[i] ? 1.0 : 0.0;
      all[is_second[i] ? 1 : 0] += j != i ? 1.0 : 0.0;
    }
  }
  return like[0] >= kLeastLike * all[0] && like[1] >= kLeastLike * all[1];
}

}  // namespace

bool ShowNoiseInParts(PilotPoints samples) {
  for (const Trait trait : {Trait::kPositionNoise, Trait::kNormalNoise}) {
    const auto noisy = std::count_if(samples.begin(), samples.end(),
                                     [trait](const PilotPoint& point) { return ShowsNoise(point, trait); });
    if (noisy > 0 && static_cast<size_t>(noisy) < samples.size()) return true;
  }
  return false;
}

size_t SplitIntoParts(PilotTable& table) {
  if (table.size() < 2 * kLeastSamples) return table.size();
  std::optional<Split> best;
  for (const Trait trait : {Trait::kPositionNoise, Trait::kNormalNoise, Trait::kSpacing}) {
    const std::optional<Split> split = SplitBy(trait, table);
    if (!split.has_value() || (best.has_value() && split->ratio <= best->ratio)) continue;
    if (IsOfItsKind(table, *split) && LieTogether(table, *split)) best = split;
  }
  if (!best.has_value()) return table.size();
  const auto second = std::stable_partition(table.begin(), table.end(),
                                            [&](const PilotPoint& point) { return !best->IsSecond(point); });
  return static_cast<size_t>(second - table.begin());
}

}  // namespace curvd
