#include "core/normals/orientation/side_repair.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/estimators/triangles/random_stream.h"
#include "core/normals/orientation/piece_sides.h"

namespace curvd {
namespace {

// Sides that fit better than this stay, whatever else might fit: so do those of right clouds.
constexpr double kFitsWell = 0.12;
// Other sides are taken only if they lessen the certificate by this factor.
constexpr double kGain = 0.5;
// Nor if they fit worse than this. Where there are many clusters, their sides can be fitted to anything, such as noise
// that is as large as the spacing of the points: then they must fit better. Measured: 0.26 and less with 280 clusters
// of noisy open sheets, where nothing may be turned; 0.016 with 280 of a plate, and 0.14 with 25 of a wedge.
constexpr double kMostAccepted = 0.25, kFreeClusters = 50.0;
// Sides that may be right, although they are not taken.
constexpr double kMostDoubtful = 0.32;
// The winding number of the best sides: one half, but for areas of points that are too small where other sheets are
// near.
constexpr double kLeastMean = 0.15;
constexpr size_t kMostSweeps = 12;

}  // namespace

SideRepair::SideRepair(const FieldPiece& field, std::vector<uint8_t> turned, bool must_close)
    : field_(field), must_close_(must_close), trials_(kStarts) {
  for (const FieldSample& sample : field.samples) weight_ += sample.weight;
  for (size_t c = 0; c < field.clusters.size(); ++c) {
    const std::span<const float> values = field.values_of(c);
    Sums sums{};
    for (size_t k = 0; k < values.size(); ++k) {
      sums.sum += field.samples[k].weight * values[k];
      sums.squares += field.samples[k].weight * values[k] * values[k];
    }
    sums_.push_back(sums);
  }
  now_.turned = std::move(turned);
  Measure(now_);
}

SideRepair::Fit SideRepair::FitOf(double sum, double squares) const {
  if (!(weight_ > 0.0)) return {};
  const double mean = sum / weight_;
  return {sum > 0.0 ? 1.0 - mean * mean / (squares / weight_) : 2.0, mean};
}

// Sets all else from the sides.
void SideRepair::Measure(Trial& trial) const {
  trial.winding.assign(field_.samples.size(), 0.0f);
  for (size_t c = 0; c < field_.clusters.size(); ++c) {
    const std::span<const float> values = field_.values_of(c);
    const float sign = trial.turned[c] != 0 ? -1.0f : 1.0f;
    for (size_t k = 0; k < values.size(); ++k) trial.winding[k] += sign * values[k];
  }
  trial.sum = trial.squares = 0.0;
  for (size_t k = 0; k < trial.winding.size(); ++k) {
    trial.sum += field_.samples[k].weight * trial.winding[k];
    trial.squares += field_.samples[k].weight * trial.winding[k] * trial.winding[k];
  }
  trial.fit = FitOf(trial.sum, trial.squares);
}

bool SideRepair::IsWanted() const { return field_.clusters.size() > 1 && now_.fit.certificate > kFitsWell; }

bool SideRepair::TurnIfBetter(size_t cluster, Trial& trial) const {
  const std::span<const float> values = field_.values_of(cluster);
  const double sign = trial.turned[cluster] != 0 ? -1.0 : 1.0;
  constexpr size_t kLanes = 8;
  float products[kLanes] = {};
  const size_t whole = values.size() / kLanes * kLanes;
  for (size_t k = 0; k < whole; k += kLanes) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      products[lane] += field_.samples[k + lane].weight * trial.winding[k + lane] * values[k + lane];
    }
  }
  double product = 0.0;
  for (const float lane : products) product += lane;
  for (size_t k = whole; k < values.size(); ++k) product += field_.samples[k].weight * trial.winding[k] * values[k];
  const double sum = trial.sum - 2.0 * sign * sums_[cluster].sum;
  const double squares = trial.squares - 4.0 * sign * product + 4.0 * sums_[cluster].squares;
  const Fit fit = FitOf(sum, squares);
  // A gain beyond rounding: turns end.
  if (!(fit.certificate < trial.fit.certificate - 1e-6)) return false;
  trial.turned[cluster] ^= 1;
  trial.sum = sum;
  trial.squares = squares;
  trial.fit = fit;
  const auto change = static_cast<float>(-2.0 * sign);
  for (size_t k = 0; k < values.size(); ++k) trial.winding[k] += change * values[k];
  return true;
}

void SideRepair::Descend(size_t start) {
  Trial trial = now_;
  RandomStream random(start, field_.piece);
  // Ever more clusters, up to a half.
  const uint64_t share = start < kStarts / 3 ? 8 : start < 2 * kStarts / 3 ? 4 : 2;
  for (size_t c = 0; start > 0 && c < trial.turned.size(); ++c) {
    if (random.Next() % share == 0) trial.turned[c] ^= 1;
  }
  Measure(trial);
  if (trial.sum < 0.0) {
    for (uint8_t& turned : trial.turned) turned ^= 1;
    Measure(trial);
  }
  for (size_t sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool is_better = false;
    for (size_t c = 0; c < trial.turned.size(); ++c) is_better |= TurnIfBetter(c, trial);
    if (!is_better) break;
  }
  Measure(trial);
  trial.winding = {};
  trials_[start] = std::move(trial);
}

bool SideRepair::MayBeTaken(const Trial& trial) const {
  if (trial.turned.empty()) return false;  // nobody made it
  if (!must_close_) return true;
  double sum[3] = {};
  for (size_t c = 0; c < trial.turned.size(); ++c) {
    for (size_t axis = 0; axis < 3; ++axis) {
      sum[axis] += static_cast<double>(field_.moments[c][axis]) * (trial.turned[c] != 0 ? -1.0 : 1.0);
    }
  }
  return std::hypot(sum[0], sum[1], sum[2]) <= kMostClosedShare * static_cast<double>(field_.area);
}

const SideRepair::Trial* SideRepair::BestTrial() const {
  const Trial* best = nullptr;
  for (const Trial& trial : trials_) {
    if (best != nullptr && !(trial.fit.certificate < best->fit.certificate)) continue;
    if (MayBeTaken(trial)) best = &trial;
  }
  return best;
}

bool SideRepair::IsPromising() const {
  const Trial* best = IsWanted() ? BestTrial() : nullptr;
  return best != nullptr && best->fit.certificate < kGain * now_.fit.certificate &&
         best->fit.certificate <= kMostDoubtful && best->fit.mean >= kLeastMean;
}

bool SideRepair::Accept() {
  const double clusters = static_cast<double>(field_.clusters.size());
  if (!IsPromising() || BestTrial()->fit.certificate > kMostAccepted / (1.0 + clusters / kFreeClusters)) return false;
  now_ = *BestTrial();
  is_accepted_ = true;
  return true;
}

}  // namespace curvd
