#include "core/scale/errors/standard_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/median.h"
#include "core/estimators/scale_ladder.h"

namespace curvd {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// The mean length of a vector of two Gaussians of standard deviation 1, the root of pi / 2.
constexpr double kMeanLength = 1.2533;
// The rung whose residuals tell the noise of normals: the smallest that has many more neighbors than coefficients.
constexpr size_t kResidualRung = 4;

// What is known at the samples near a point.
class Nearby {
 public:
  Nearby(std::span<const uint32_t> nearest, const std::vector<ErrorSample>& samples) {
    for (const uint32_t i : nearest) {
      if (samples[i].is_known && size_ < near_.size()) near_[size_++] = &samples[i];
    }
  }

  size_t size() const { return size_; }

  template <typename Value>
  double MeanOf(const Value& value) const {
    double sum = 0.0;
    for (size_t i = 0; i < size_; ++i) sum += value(*near_[i]);
    return sum / static_cast<double>(size_);
  }

  double MeanOf(ShapeParts ErrorSample::*member, size_t part) const {
    return MeanOf([&](const ErrorSample& sample) { return (sample.*member)[part]; });
  }

 private:
  std::array<const ErrorSample*, ErrorModel::kNearest> near_{};
  size_t size_ = 0;
};

}  // namespace

StandardErrors ErrorModel::At(std::span<const uint32_t> nearest, double mean, double half_difference) const {
  if (samples_.empty()) return {kNaN, kNaN, kNaN};
  const Nearby near(nearest, samples_);
  if (near.size() == 0 || near.size() < std::min(kLeastNearest, samples_.size())) return {kNaN, kNaN, kNaN};
  const double noise_bias = near.MeanOf([](const ErrorSample& sample) { return sample.noise_bias; });
  const double half_noise_bias = near.MeanOf([](const ErrorSample& sample) { return sample.half_noise_bias; });
  const double lean = near.MeanOf([](const ErrorSample& sample) { return sample.lean; });
  const double floor = near.MeanOf([](const ErrorSample& sample) { return sample.floor; });
  const std::array values = {mean, mean - half_difference, mean + half_difference};  // of H, k1 and k2
  ShapeParts squares;
  for (size_t part = 0; part < kShapeParts; ++part) {
    const double lost = part < values.size() ? attenuation_.of[part].LostAt(values[part]) : 0.0;
    squares[part] = near.MeanOf(&ErrorSample::noise, part) +
                    std::max(near.MeanOf(&ErrorSample::detail, part), lost * lost) +
                    std::max(near.MeanOf(&ErrorSample::place, part), 0.0) + noise_bias + floor * floor;
  }
  squares[kFirstPart] += half_noise_bias;
  squares[kSecondPart] += half_noise_bias;
  // Where k1 and k2 are nearly equal, what would turn the directions drives them apart, always the same way; the error
  // of H, which has a sign as well, adds to that of one and takes from that of the other.
  const double turn = std::sqrt(squares[kTurnPart]);
  const double apart = kMeanLength * turn * (half_difference > 2.0 * turn ? 2.0 * turn / half_difference : 1.0);
  const auto root = [&](double square) { return std::sqrt(std::max(square, floor * floor)); };
  return {root(squares[kMeanPart]), root(squares[kFirstPart] + apart * apart - 2.0 * lean * apart),
          root(squares[kSecondPart] + apart * apart + 2.0 * lean * apart)};
}

std::optional<double> NormalNoise(PilotPoints table, double position_noise) {
  std::vector<double> squares;
  for (const PilotPoint& point : table) {
    const double residual = point.normal_residual[kResidualRung];
    const auto at_rung = [](const PilotPoint::Estimates& estimates) {
      return double{estimates[kRegressionMethod][kResidualRung][PilotPoint::kAll]};
    };
    const double mean = at_rung(point.mean), difference = at_rung(point.difference), twist = at_rung(point.twist);
    // A point that was moved along the surface has the normal of another place: along each axis, the noise of positions
    // times a curvature, whose square is (k1^2 + k2^2) / 2 in the mean.
    const double bend = mean * mean + difference * difference + twist * twist;
    const double square = residual * residual - bend * position_noise * position_noise;
    if (std::isfinite(square)) squares.push_back(square);
  }
  if (squares.empty()) return std::nullopt;
  return std::sqrt(std::max(Median(squares), 0.0));
}

}  // namespace curvd
