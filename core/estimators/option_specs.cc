#include "core/estimators/option_specs.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "core/base/number_text.h"

namespace curvd {

bool OptionSpec::InRange(const EstimatorOptions& options) const {
  if (const auto* number = std::get_if<uint32_t EstimatorOptions::*>(&member)) {
    return options.**number >= least && options.**number <= most;
  }
  if (const auto* number = std::get_if<double EstimatorOptions::*>(&member)) {
    return options.**number >= least && options.**number <= most;
  }
  return true;
}

std::string OptionSpec::ValueText(const EstimatorOptions& options) const {
  if (const auto* number = std::get_if<double EstimatorOptions::*>(&member)) return NumberText(options.**number);
  return std::visit([&options](auto field) { return absl::StrCat(options.*field); }, member);
}

std::span<const OptionSpec> OptionSpecs() {
  using Options = EstimatorOptions;
  static constexpr std::array<OptionSpec, 8> kSpecs = {{
      {"triangle_count", &Options::triangle_count, 1, kMaxTriangleCount, "triangles that random strategies draw"},
      {"rotation_count", &Options::rotation_count, 1, kMaxRotations, "hexagrams that avg-hexagram averages over"},
      {"jet_degree", &Options::jet_degree, kMinJetDegree, kMaxJetDegree, "degree of the polynomial that a jet is"},
      {"regression_degree", &Options::regression_degree, kMinRegressionDegree, kMaxRegressionDegree,
       "degree of the polynomials that normal-regression fits to the normals"},
      {"average_normal_weight", &Options::average_normal_weight, 0, 1, "share of the neighborhood's mean normal"},
      {"even_weights", &Options::even_weights, 0, 1, "all triangles of delaunay count alike"},
      {"project", &Options::project, 0, 1, "aso estimates the surface beside the point, not the level through it"},
      {"seed", &Options::seed, 0, 0, "of the random strategies"},
  }};
  return kSpecs;
}

}  // namespace curvd
