#include "client/surfaces/shell_sampler.h"

#include <algorithm>
#include <functional>
#include <numbers>

#include "client/surfaces/random.h"

namespace curv {
namespace {

constexpr double kHalfThickness = 1.5;     // of the shell, in cells
constexpr double kCellsPerPoint = 2.0;     // area of the surface in cell faces, for each point wanted
constexpr double kMinCellsPerSide = 96.0;  // so that the shell is thin against the curvature of the surface
constexpr int kUnculledLevels = 5;         // |f| / |gradient| says little about distance in larger cells

// Visits the trials that hit the shell.
class ShellWalk {
 public:
  using Visitor = std::function<void(const Vec3&)>;

  ShellWalk(const Surface& surface, double cell, uint64_t seed)
      : surface_(surface), bounds_(surface.bounds()), cell_(cell), random_(seed, /*stream=*/1) {
    // Open faces cut the shell, closed ones must hold all of it.
    double side = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double margin = surface.is_open(axis) ? 0.0 : 2.0 * cell;
      bounds_.low[axis] -= margin;
      bounds_.high[axis] += margin;
      side = std::max(side, bounds_.high[axis] - bounds_.low[axis]);
    }
    while (std::ldexp(cell, levels_) < side) ++levels_;
  }

  // Calls visit(trial) for each hit, in the order of the curve. The hits are the same in each walk.
  void Run(const Visitor& visit) const { Descend(bounds_.low, levels_, 0, visit); }

 private:
  void Descend(const Vec3& low, int level, uint64_t code, const Visitor& visit) const {
    if (level == 0) return Try(low, code, visit);
    const double half = 0.5 * std::ldexp(cell_, level);
    if (!MayHit(low, half, level)) return;
    for (uint64_t child = 0; child < 8; ++child) {
      const Vec3 offset{child & 1 ? half : 0.0, child & 2 ? half : 0.0, child & 4 ? half : 0.0};
      Descend(low + offset, level - 1, 8 * code + child, visit);
    }
  }

  bool MayHit(const Vec3& low, double half, int level) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (low[axis] > bounds_.high[axis]) return false;
    }
    if (level > levels_ - kUnculledLevels) return true;
    Vec3 gradient;
    const double value = surface_.Evaluate(low + Vec3{half, half, half}, gradient);
    // Half the diagonal, with a margin of 40 % for the bending of the level sets within the cell.
    const double reach = 1.4 * std::numbers::sqrt3 * half + kHalfThickness * cell_;
    return std::abs(value) <= reach * Norm(gradient);
  }

  void Try(const Vec3& low, uint64_t code, const Visitor& visit) const {
    Vec3 trial = low;
    for (int axis = 0; axis < 3; ++axis) {
      trial[axis] += cell_ * random_.Uniform(3 * code + static_cast<uint64_t>(axis));
      if (trial[axis] > bounds_.high[axis]) return;
    }
    Vec3 gradient;
    const double value = surface_.Evaluate(trial, gradient);
    if (std::abs(value) <= kHalfThickness * cell_ * Norm(gradient)) visit(trial);
  }

  const Surface& surface_;
  Box bounds_;
  double cell_;
  CounterRandom random_;
  int levels_ = 0;
};

size_t CountHits(const ShellWalk& walk) {
  size_t hits = 0;
  walk.Run([&](const Vec3&) { ++hits; });
  return hits;
}

double Area(size_t hits, double cell) { return static_cast<double>(hits) * cell * cell / (2.0 * kHalfThickness); }

}  // namespace

ShellSample SampleShell(const Surface& surface, size_t points, uint64_t seed) {
  const Box bounds = surface.bounds();
  const Vec3 extent = bounds.high - bounds.low;
  const double coarse = std::max({extent.x, extent.y, extent.z}) / kMinCellsPerSide;
  const double rough_area = Area(CountHits(ShellWalk(surface, coarse, seed)), coarse);
  const double fine = std::sqrt(rough_area / (kCellsPerPoint * static_cast<double>(points)));

  const double cell = std::min(coarse, fine);
  const ShellWalk walk(surface, cell, seed);
  const size_t hits = CountHits(walk);

  ShellSample sample{.positions = {}, .area = Area(hits, cell)};
  sample.positions.reserve(points);
  // Hit i is kept where i * points / hits reaches a new integer: exactly `points` times, since hits >= points.
  size_t carry = hits / 2;
  walk.Run([&](const Vec3& trial) {
    carry += points;
    if (carry < hits) return;
    carry -= hits;
    sample.positions.push_back(surface.ProjectWithin(trial));
  });
  return sample;
}

}  // namespace curv
