// Parts of a cloud that differ in their noise or their density so much that each is judged for itself.
#pragma once

#include <cstddef>

#include "core/index/spatial_index.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// The rungs that tell noise, and noise from detail.
inline constexpr size_t kRungsThatTellNoise = 9;

// Finds two parts of a cloud, if it has such, of which the second has more noise, or fewer points to an area: residuals
// of fits, or radii of neighborhoods, are at least twice as large at nearly all sampled points of it as at nearly all
// of the first, and points of each lie among their like. Puts the samples of the second part after those of the first,
// and returns where they begin; table.size(): there is one part alone. Neighborhoods of 256 points, which not every
// table has, tell noise from detail: without them, parts are those of density.
size_t SplitIntoParts(PilotTable& table);

// Whether some of the samples show noise, and others none: that may be a part of the cloud, however few they are.
bool ShowNoiseInParts(PilotPoints samples);

// Which part of a cloud a place belongs to. For one box at a time, as NearestSamples. Not thread-safe.
class PartFinder {
 public:
  // As SplitIntoParts left them.
  PartFinder(PilotPoints samples, size_t second)
      : nearest_(samples), around_(samples), second_(second), has_two_(second < samples.size()) {}

  void Start(const Box& box) {
    if (!has_two_) return;
    nearest_.Start(box, kNearest);
    around_.Start(box, kAround);
  }
  // Where both are near, the second one: estimates that average its noise serve exact points, too, and those that suit
  // exact points fail among noisy ones.
  size_t PartAt(const float* position) { return has_two_ && nearest_.At(position).back() >= second_ ? 1 : 0; }
  // Whether the second part is so near that neighborhoods may reach into it.
  bool IsNearSecond(const float* position) { return has_two_ && around_.At(position).back() >= second_; }

  size_t bytes() const { return nearest_.bytes() + around_.bytes(); }
  static size_t MostBytes(size_t samples) { return 2 * NearestSamples::MostBytes(samples); }

 private:
  // No more, since a sample beside the border, whose neighborhood has points of both parts, is of the second itself.
  static constexpr size_t kNearest = 2;
  // All samples around a place, and some of those around them.
  static constexpr size_t kAround = 12;

  NearestSamples nearest_, around_;
  size_t second_;
  bool has_two_;
};

}  // namespace curvd
