// Averages estimates of one point.
#pragma once

#include <array>
#include <optional>

#include "core/estimators/curvature_field.h"
#include "core/scale/of_quantities.h"

namespace curvd {

// Usage: Add each estimate with its weight, then Finish. In doubles.
class Blend {
 public:
  // An estimate whose status is not kOk has no weight, whatever the weights are. One of weights 0 counts for nothing,
  // nor does its radius. With `most_spread` it may be steady: the first of these is the result where the estimates
  // contradict each other, which is where their mean curvatures have a spread of more than a tenth of its largest
  // principal curvature, and more than `most_spread`. REQUIRES: weights are not negative, and one is 0 only if all are.
  void Add(const PointCurvature& estimate, const OfQuantities<double>& weights,
           std::optional<double> most_spread = std::nullopt);
  // The weighted mean of the shape operators, as curvature: H is the mean of the mean curvatures; half of k2 - k1, d1
  // and d2 come of the mean traceless tensor, and lie in the plane normal to the mean normal. The radius is the
  // largest: how far any of them looked. Where they contradict each other, the steady one. If no estimate had a weight,
  // the status of the one that was to have the largest.
  PointCurvature Finish() const;
  // Of the mean curvatures so far.
  double weight() const { return weights_.mean; }
  // Whether there is a steady estimate, and the estimates contradict each other.
  bool IsContradictory() const;

  // The mean curvature of the result so far. REQUIRES: weight() > 0.
  double mean() const { return IsContradictory() ? steady_->mean : mean_ / weights_.mean; }

  // By how much the estimates differ from their average: weighted standard deviations. 0 where one alone has a weight.
  struct Spread {
    double mean, k1, k2;
  };
  Spread spread() const;

 private:
  void AddToSpread(const PointCurvature& estimate, const OfQuantities<double>& weights);

  OfQuantities<double> weights_;
  double mean_ = 0.0, gaussian_ = 0.0;
  // Weighted sums of what H is beyond that of the first estimate, with the weights of H, and of what half of k2 - k1
  // is, with those of the traceless part; of their squares; and of both and of their product, with the root of the
  // product of the weights.
  struct Beyond {
    double mean = 0.0, half = 0.0, mean_square = 0.0, half_square = 0.0;
    double root_weight = 0.0, root_mean = 0.0, root_half = 0.0, root_product = 0.0;
  } beyond_;
  double first_mean_ = 0.0, first_half_ = 0.0;
  std::array<double, 6> tensor_{};  // xx xy xz yy yz zz
  std::array<double, 3> normal_{};
  float radius_ = 0.0f;
  std::optional<PointCurvature> steady_;
  double most_spread_ = 0.0;
  double most_refused_ = -1.0;
  PointCurvature refused_ = UndefinedCurvature(PointStatus::kTooFewNeighbors);
};

}  // namespace curvd
