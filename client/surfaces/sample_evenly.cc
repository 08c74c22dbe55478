#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/surfaces/random.h"
#include "client/surfaces/relaxation.h"
#include "client/surfaces/shell_sampler.h"
#include "client/surfaces/surface.h"

namespace curv {
namespace {

// Fisher and Yates. The modulus favors small numbers by 2^-37 at most for the sizes allowed.
void Shuffle(std::vector<Vec3>& positions, uint64_t seed) {
  const CounterRandom random(seed, /*stream=*/2);
  for (size_t i = positions.size(); i > 1; --i) std::swap(positions[i - 1], positions[random.Bits(i) % i]);
}

}  // namespace

absl::StatusOr<std::vector<Vec3>> SampleEvenly(const Surface& surface, size_t points, uint64_t seed) {
  if (points < 1 || points > kMaxSamplePoints) {
    return absl::InvalidArgumentError(absl::StrCat("points is ", points, ": it must be from 1 to ", kMaxSamplePoints));
  }
  ShellSample sample = SampleShell(surface, points, seed);
  Relax(surface, sample.area, sample.positions);
  Shuffle(sample.positions, seed);
  return std::move(sample.positions);
}

}  // namespace curv
