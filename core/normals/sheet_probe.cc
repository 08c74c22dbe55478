#include "core/normals/sheet_probe.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>

#include "Eigen/Cholesky"
#include "core/base/median.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

// From rung to rung, or over one, the count doubles.
constexpr uint32_t kLadder[] = {12, 17, 24, 34, 48, 96, 192, 384};
// Sheets are looked for from this many neighbors on: the shape of a distribution takes some values.
constexpr uint32_t kLeastForShape = 48;
// Residuals that are more even than that come from two sheets: noise of even distribution reaches 0.75.
constexpr double kTwoSheets = 0.78;
// They deviate at least so much, in units of the spacing, and hardly more in a neighborhood of twice as many points.
// The bends of one sheet make residuals of any shape, but small ones, which grow.
constexpr double kLeastThickness = 0.15, kPlateau = 1.25;
// Nor do layers count that a lattice explains on which positions lie: two layers, one step apart, deviate by half of
// it.
constexpr double kLeastSteps = 0.75;
// A neighborhood is of one sheet if its residuals deviate by less than this share of those of both.
constexpr double kOneSheet = 0.32;
// The neighbors to take where no count that was tried keeps to one sheet.
constexpr uint32_t kFewNeighbors = 24;
// In smaller neighborhoods, in units of the deviation, the residual is that of a ball of points.
constexpr double kLeastRadius = 5.0;
constexpr size_t kMostGroups = 64;
// A neighborhood of more than this share of the cloud is no neighborhood.
constexpr size_t kLargestShare = 3;
constexpr int kQuadricSize = JetSize(2);

using Quadric = Eigen::Matrix<double, kQuadricSize, 1>;

// A neighbor in the frame of the plane that lies best.
struct Place {
  double u, v, height;
};

Quadric MonomialsAt(const Place& place) {
  Quadric out;
  out << 1.0, place.u, place.v, place.u * place.u, place.u * place.v, place.v * place.v;
  return out;
}

// Calls use(place) for each neighbor of point i, in units of rho.
template <typename Use>
void ForEachPlace(const NormalScratch& s, size_t i, const Use& use) {
  const NeighborArrays& n = s.neighbors;
  const JetSystems& frame = s.system;
  const double unit = 1.0 / s.frames.rho[i];
  for (size_t j = 0; j < n.count; ++j) {
    const double x = n.dx[j] * unit, y = n.dy[j] * unit, z = n.dz[j] * unit;
    const auto along = [&](const GroupDoubleVectors& axis) { return x * axis.x[i] + y * axis.y[i] + z * axis.z[i]; };
    use(Place{along(frame.u), along(frame.v), along(frame.axis)});
  }
}

// The least squares quadric as height over the plane.
Quadric FitQuadric(const NormalScratch& s, size_t i) {
  Eigen::Matrix<double, kQuadricSize, kQuadricSize> moments;
  moments.setZero();
  Quadric heights = Quadric::Zero();
  ForEachPlace(s, i, [&](const Place& place) {
    const Quadric monomials = MonomialsAt(place);
    moments.noalias() += monomials * monomials.transpose();
    heights += place.height * monomials;
  });
  return moments.ldlt().solve(heights);
}

}  // namespace

SheetProbe::SheetProbe(const SpatialIndex& index, uint32_t max_neighbor_count, int thread_count)
    : index_(index), groups_(SampleGroups(index, kMostGroups)), scratch_(thread_count) {
  const size_t most = std::min<size_t>(index.point_count() / kLargestShare, max_neighbor_count);
  for (const uint32_t count : kLadder) {
    if (count > most) break;
    counts_.push_back(count);
    plans_.emplace_back(PlaneFit(count), index);
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  outcomes_.assign(block_count() * SpatialIndex::kGroupLeaves, {kNan, kNan, kNan});
}

absl::Status SheetProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  Outcome* const outcomes = &outcomes_[block * SpatialIndex::kGroupLeaves];
  scratch.inspect = [&scratch, outcomes](size_t i) {
    const Quadric quadric = FitQuadric(scratch, i);
    double sum = 0.0, squares = 0.0;
    ForEachPlace(scratch, i, [&](const Place& place) {
      const double residual = place.height - quadric.dot(MonomialsAt(place));
      sum += std::abs(residual);
      squares += residual * residual;
    });
    const double count = static_cast<double>(scratch.neighbors.count), rho = scratch.frames.rho[i];
    outcomes[i].radius = static_cast<float>(rho);
    outcomes[i].variance = static_cast<float>(squares / (count - kQuadricSize) * rho * rho);
    outcomes[i].evenness = squares > 0.0 ? static_cast<float>(sum * sum / (count * squares)) : 0.0f;
  };
  const size_t rung = block / groups_.size(), group = block % groups_.size();
  return FitGroup(index_, plans_[rung], groups_[group], GroupSample::kOneOfEachLeaf, scratch);
}

std::vector<SheetProbe::Rung> SheetProbe::Rungs() const {
  const size_t samples = groups_.size() * SpatialIndex::kGroupLeaves;
  std::vector<Rung> rungs;
  for (size_t rung = 0; rung < counts_.size(); ++rung) {
    std::vector<double> radii, variances, evenness;
    for (size_t i = 0; i < samples; ++i) {
      const Outcome& point = outcomes_[rung * samples + i];
      if (std::isnan(point.variance)) continue;
      radii.push_back(point.radius);
      variances.push_back(point.variance);
      evenness.push_back(point.evenness);
    }
    if (radii.empty()) continue;
    rungs.push_back({counts_[rung], Median(radii), std::sqrt(Median(variances)), Median(evenness)});
  }
  return rungs;
}

SheetFinding SheetProbe::Find() const {
  SheetFinding finding;
  const std::vector<Rung> rungs = Rungs();
  if (rungs.empty()) return finding;
  const Rung& smallest = rungs.front();
  finding.spacing = smallest.radius * std::sqrt(std::numbers::pi / smallest.count);
  std::optional<double> both;
  // Positions on a coarse lattice lie in layers, too.
  const double least = std::max(kLeastThickness * finding.spacing, kLeastSteps * LatticeStep(index_));
  for (size_t i = 0; i + 1 < rungs.size() && !both.has_value(); ++i) {
    const Rung &rung = rungs[i], &next = rungs[i + 1];
    if (rung.count < kLeastForShape) continue;
    finding.evenness = std::max(finding.evenness, rung.evenness);
    if (rung.evenness < kTwoSheets) continue;
    if (rung.deviation < least || next.deviation > kPlateau * rung.deviation) continue;
    both = rung.deviation;
  }
  finding.two_sheets = finding.is_mixed = both.has_value();
  if (finding.two_sheets) finding.neighbor_count = std::min(kFewNeighbors, rungs.back().count);
  for (const Rung& rung : rungs) {
    if (finding.two_sheets) {
      if (rung.deviation > kOneSheet * *both) break;
      finding.neighbor_count = rung.count;
      finding.is_mixed = false;
      finding.noise = smallest.deviation;
    } else {
      finding.noise = rung.deviation;
      if (rung.count >= 24 && rung.radius >= kLeastRadius * rung.deviation) break;
    }
  }
  finding.unlike_noise = finding.two_sheets || (finding.evenness > kMostEvenNoise && finding.noise >= least);
  return finding;
}

size_t SheetProbe::ScratchBytes(size_t point_count, uint32_t max_neighbor_count) {
  return NormalScratch::MostBytes(PlaneFit(std::min(kLadder[std::size(kLadder) - 1], max_neighbor_count)), point_count);
}

}  // namespace curvd
