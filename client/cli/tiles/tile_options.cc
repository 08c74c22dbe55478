#include "client/cli/tiles/tile_options.h"

#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/tiles/reading/json_fields.h"

namespace curv {
namespace {

// Delaunay's umbrellas of a neighborhood lie within three radii where they have at least so many points to choose from.
constexpr uint32_t kDelaunayNeighbors = 31;

}  // namespace

absl::StatusOr<TileReach> ReachOf(const EstimateOptions& options) {
  const std::string name(EstimatorName(options.estimator));
  if (options.automatic_scale.has_value() || options.estimator == Estimator::kAuto) {
    return absl::InvalidArgumentError(
        "--auto and --k=auto choose by the whole cloud, which no tile has: estimate a part with --auto, and give the "
        "--estimator and --k that its summary shows");
  }
  if (!options.neighbor_counts.empty()) {
    return absl::InvalidArgumentError("--k is a list; tiles take one number of neighbors");
  }
  TileReach reach{.neighbor_count = options.radius.has_value() ? 0 : options.neighbor_count,
                  .radius = options.radius.value_or(0.0),
                  .factor = 1.0};
  switch (options.estimator) {
    case Estimator::kAvgHexagram:
    case Estimator::kJetFitting:
    case Estimator::kAlgebraicShapeOperator:
    case Estimator::kNormalRegression:
    case Estimator::kUniform:
    case Estimator::kIndependent:
      return reach;
    case Estimator::kHexagram:  // its corners are up to a third of the radius outside
      reach.factor = 4.0 / 3.0;
      return reach;
    case Estimator::kDelaunay:
      if (reach.neighbor_count >= kDelaunayNeighbors) {
        reach.factor = 3.0;
        return reach;
      }
      return absl::InvalidArgumentError(absl::StrCat(
          "--estimator=delaunay in tiles takes --k of ", kDelaunayNeighbors,
          " or more: nothing bounds how far the umbrellas of smaller neighborhoods, or of a --radius, reach"));
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("--estimator=", name, ": nothing bounds how far around a point it looks, which tiles ask for"));
  }
}

nlohmann::ordered_json JsonOf(const EstimateOptions& options) {
  nlohmann::ordered_json json = {{"estimator", std::string(EstimatorName(options.estimator))}};
  if (options.radius.has_value()) {
    json["radius"] = *options.radius;
  } else {
    json["neighbor_count"] = options.neighbor_count;
  }
  json["triangle_count"] = options.triangle_count;
  json["seed"] = options.seed;
  json["rotation_count"] = options.rotation_count;
  if (options.jet_degree.has_value()) json["jet_degree"] = *options.jet_degree;
  json["regression_degree"] = options.regression_degree;
  json["even_weights"] = options.even_weights;
  json["project"] = options.project;
  if (options.average_normal_weight.has_value()) json["average_normal_weight"] = *options.average_normal_weight;
  json["quantities"] = options.quantities;
  json["skip_invalid"] = options.skip_invalid;
  return json;
}

absl::StatusOr<EstimateOptions> OptionsOf(const nlohmann::ordered_json& json) {
  EstimateOptions options;
  try {
    const std::string name = TextOf(json, "estimator");
    const std::optional<Estimator> estimator = EstimatorOf(name);
    if (!estimator.has_value()) {
      return absl::FailedPreconditionError(absl::StrCat("the plan's estimator, ", name, ", is not known to this curv"));
    }
    options.estimator = *estimator;
    constexpr double kMost = std::numeric_limits<double>::max();
    const auto count = [&json](const char* name) {
      return static_cast<uint32_t>(UnsignedOf(json, name, ~uint32_t{0}));
    };
    if (json.contains("radius")) options.radius = NumberOf(json, "radius", 0.0, kMost);
    if (json.contains("neighbor_count")) options.neighbor_count = count("neighbor_count");
    options.triangle_count = count("triangle_count");
    options.seed = UnsignedOf(json, "seed");
    options.rotation_count = count("rotation_count");
    if (json.contains("jet_degree")) options.jet_degree = count("jet_degree");
    // Plans of before have neither this nor `project`.
    if (json.contains("regression_degree")) options.regression_degree = count("regression_degree");
    options.even_weights = FlagOf(json, "even_weights");
    if (json.contains("project")) options.project = FlagOf(json, "project");
    if (json.contains("average_normal_weight")) {
      options.average_normal_weight = NumberOf(json, "average_normal_weight", 0.0, kMost);
    }
    options.quantities = TextsOf(json, "quantities");
    options.skip_invalid = FlagOf(json, "skip_invalid");
  } catch (const BadField& error) {
    return absl::FailedPreconditionError(absl::StrCat("the plan's options: ", error.what()));
  }
  return options;
}

}  // namespace curv
