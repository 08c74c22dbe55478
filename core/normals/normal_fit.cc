#include "core/normals/normal_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>

#include "core/estimators/options.h"

namespace curvd {
namespace {

// Noise leaves a variance whose standard deviation is √(2 / freedom) times its mean. What is found of sigma is up to a
// tenth too small, since balls cut off some of the noise: hence 1.15. With 1.1 and 2, or 1.3 and 5, H errs alike on
// noisy solids.
constexpr double kSlackOfNoise = 1.15, kDeviationsOfNoise = 3.0;

}  // namespace

double EdgePart::MostOfNoise(double freedom) { return kSlackOfNoise + kDeviationsOfNoise * std::sqrt(2.0 / freedom); }

NormalFit FitOfNoisyPart(const NormalFit& whole) {
  NormalFit fit = whole;
  fit.method = whole.noisy_part->method;
  fit.neighborhood = whole.noisy_part->neighborhood;
  fit.shares = whole.noisy_part->shares;
  fit.crosses_lines = whole.noisy_part->crosses_lines;
  fit.noisy_part.reset();
  return fit;
}

EstimatorOptions NormalFit::ToEstimatorOptions() const {
  EstimatorOptions options;
  options.estimator = "jet";
  std::visit([&options](const auto& points) { options.neighborhood = points; }, neighborhood);
  options.jet_degree = static_cast<uint32_t>(std::max(JetDegree(method), 1));
  options.max_neighbor_count = max_neighbor_count;
  return options;
}

EstimatorOptions NormalFit::OptionsForOnePoint() const {
  EstimatorOptions options = ToEstimatorOptions();
  auto* const neighbors = std::get_if<NeighborCount>(&options.neighborhood);
  if (shares && neighbors != nullptr) neighbors->count /= SpatialIndex::kLeafSize;
  if (!noisy_part.has_value()) return options;
  EstimatorOptions noisy = FitOfNoisyPart(*this).OptionsForOnePoint();
  return std::get<NeighborCount>(noisy.neighborhood).count > std::get<NeighborCount>(options.neighborhood).count
             ? noisy
             : options;
}

NormalFit PlaneFit(size_t neighbor_count) {
  NormalFit fit;
  fit.method = NormalMethod::kPca;
  fit.neighborhood = NeighborCount{static_cast<uint32_t>(neighbor_count)};
  return fit;
}

}  // namespace curvd
