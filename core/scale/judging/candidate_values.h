// What every candidate of the automatic choice estimated at the sampled points, to be gone through candidate by
// candidate.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// A copy of what a table of estimates says of one quantity. There, the values of one candidate lie kilobytes apart.
// Const methods are thread-safe.
class CandidateValues {
 public:
  // The mean curvature, the traceless part of the shape operator, which is a vector of two components, or the Gaussian
  // curvature. In 1 / length or its square, with the index's unit of length.
  enum class Quantity : uint8_t { kMean, kTraceless, kGaussian };

  // Of one candidate at every sampled point, by component; those of a number are one. NaN where nothing is known.
  struct Column {
    std::span<const double> first, second;
    size_t size() const { return first.size(); }
    // How long the vector at a point is.
    double LengthAt(size_t i) const { return second.empty() ? std::abs(first[i]) : Length(first[i], second[i]); }
    // How far the vectors of two candidates, or of one in two parts, lie apart at a point.
    double DistanceAt(size_t i, const Column& other) const {
      const double distance = first[i] - other.first[i];
      return second.empty() ? std::abs(distance) : Length(distance, second[i] - other.second[i]);
    }
    // Squares of floats do not overflow in doubles.
    static double Length(double x, double y) { return std::sqrt(x * x + y * y); }
  };

  CandidateValues(PilotPoints table, Quantity quantity);

  // As long as the object lives.
  Column Of(const ScaleCandidate& candidate, PilotPoint::Part part = PilotPoint::kAll) const;

  static constexpr size_t BytesPerSample(Quantity quantity) {
    return (kMethodCount * kRungCount * PilotPoint::kParts * ComponentsOf(quantity) + 1) * sizeof(double);
  }

 private:
  static constexpr size_t ComponentsOf(Quantity quantity) { return quantity == Quantity::kTraceless ? 2 : 1; }
  static constexpr size_t kUnknown = std::numeric_limits<size_t>::max();

  // Gives a place to each candidate that has an estimate at any point, and returns how many have.
  size_t PlaceCandidates(PilotPoints table);
  // Copies what `points`, a few that follow one another, hold into each column from `first` on.
  void Copy(PilotPoints points, size_t first);

  const size_t samples_;
  const Quantity quantity_;
  std::array<std::array<size_t, kRungCount>, kMethodCount> places_;  // kUnknown: it has no estimate anywhere
  std::vector<double> values_;                                       // by place, part, component and point
  std::vector<double> none_;                                         // NaN for each point
};

}  // namespace curvd
