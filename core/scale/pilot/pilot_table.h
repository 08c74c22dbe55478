// What was estimated at the sampled points of a cloud, at every scale, by every method.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/estimators/scale_ladder.h"

namespace curvd {

// Lengths are in the index's unit. NaN: there was no estimate.
struct PilotPoint {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  // Of all neighbors, and of each half of them: those with an even hash of the index, and the others.
  enum Part : uint8_t { kAll, kEven, kOdd };
  static constexpr size_t kParts = 3;

  std::array<float, 3> position;
  // Of each method, rung and part: the shape operator in a frame of the point's own, which all of them share
  // (TangentShape).
  using Estimates = std::array<std::array<std::array<float, kParts>, kRungCount>, kMethodCount>;
  Estimates mean;  // curvature
  Estimates difference;
  Estimates twist;
  // Of the regression of normals: how the shape operator changes along the frame's axes: mean, difference and twist
  // along x, then those along y.
  std::array<std::array<std::array<float, 6>, kParts>, kRungCount> slope;
  std::array<float, kRungCount> radius;           // of the neighborhood
  std::array<float, kRungCount> steepest;         // principal curvature by magnitude, of the hexagrams
  std::array<float, kRungCount> residual;         // of positions, from the jet
  std::array<float, kRungCount> normal_residual;  // of normals along a tangent, from the regression of normals

  // How far the next line of points is from the one that the point lies on, and the cosine and sine of twice the angle
  // of that line in the point's frame. 0: it lies on none.
  float line_distance = 0.0f;
  std::array<float, 2> line{1.0f, 0.0f};

  // Rungs whose neighborhoods reach over no sharp edge; others have no estimates.
  size_t clear_rungs = kRungCount;

  // Takes the estimates of the rungs from `count` on back, which reach over an edge.
  void KeepClear(size_t count) {
    clear_rungs = count;
    KeepRungs(count);
  }

  // Takes the estimates of the rungs from `count` on back.
  void KeepRungs(size_t count) {
    for (size_t rung = count; rung < kRungCount; ++rung) {
      for (Estimates* const estimates : {&mean, &difference, &twist}) {
        for (auto& rungs : *estimates) rungs[rung].fill(kNone);
      }
      for (auto& slopes : slope[rung]) slopes.fill(kNone);
      for (auto* rungs : {&steepest, &residual, &normal_residual}) (*rungs)[rung] = kNone;
    }
  }

  // Stands where no point was sampled.
  static PilotPoint None() { return PilotPoint({kNone, kNone, kNone}); }
  bool is_sampled() const { return position[0] == position[0]; }

  // Without any estimate.
  explicit PilotPoint(const std::array<float, 3>& at) : position(at) {
    for (Estimates* const estimates : {&mean, &difference, &twist}) {
      for (auto& rungs : *estimates) {
        for (auto& parts : rungs) parts.fill(kNone);
      }
    }
    for (auto& parts : slope) {
      for (auto& slopes : parts) slopes.fill(kNone);
    }
    for (auto* rungs : {&radius, &steepest, &residual, &normal_residual}) rungs->fill(kNone);
  }
};

using PilotTable = std::vector<PilotPoint>;
// Some of a table.
using PilotPoints = std::span<const PilotPoint>;

}  // namespace curvd
