#include "client/cli/quantities/quantity_flags.h"

#include <algorithm>
#include <array>

#include "client/cli/flags.h"
#include "client/cli/result_columns.h"

namespace curv {
namespace {

constexpr char kNormalCurvature[] = "normal_curvature";

void AddList(CLI::App& command, const char* flag, const char* help, std::vector<std::string>& words) {
  command.add_option(flag, words, help)
      ->delimiter(',')
      ->allow_extra_args(false)  // what follows the list is the input
      ->check(CLI::IsMember(QuantityWords()).description(""))
      ->option_text("LIST");
}

}  // namespace

void AddQuantitiesFlag(CLI::App& command, QuantityFlags& flags) {
  AddList(command, "--quantities",
          "what to estimate, with commas between: mean, gaussian, k1, k2, d1, d2, radius, those of --also, or the "
          "contract's names; the result has no other columns, but k1 and k2 come together, and so do d1 and d2 [all of "
          "curvature but those of --also]",
          flags.only);
}

void AddQuantityFlags(CLI::App& command, QuantityFlags& flags) {
  AddQuantitiesFlag(command, flags);
  AddList(command, "--also",
          "what to estimate beside that: shape_index, curvedness; standard_errors, of auto, avg-hexagram, "
          "normal-regression, jet of degree 4, and aso with --project, with --k=auto or 16 to 2,048 neighbors; "
          "chosen_neighbor_count and "
          "estimator_weights, of --auto",
          flags.also);
  CLI::Option* direction =
      command
          .add_option("--direction", flags.direction,
                      "add the normal curvature in a direction, projected on the tangent plane: an axis, or X,Y,Z")
          ->check(Direction())
          ->option_text("X,Y,Z");
  command
      .add_option("--direction-columns", flags.direction_columns,
                  "the same in the direction of each point, the input's columns NAMEx NAMEy NAMEz")
      ->excludes(direction)
      ->option_text("NAME");
}

void AddQuantity(const std::string& word, std::vector<std::string>& quantities) {
  const std::string name = ContractName(word);
  if (std::find(quantities.begin(), quantities.end(), name) == quantities.end()) quantities.push_back(name);
}

void ApplyQuantities(const QuantityFlags& flags, EstimateOptions& options) {
  const bool has_direction = !flags.direction.empty() || !flags.direction_columns.empty();
  for (const std::string& word : flags.only) AddQuantity(word, options.quantities);
  if (options.quantities.empty() && (!flags.also.empty() || has_direction)) options.quantities = DefaultQuantityNames();
  for (const std::string& word : flags.also) AddQuantity(word, options.quantities);
  const auto is_asked = [&options](const char* name) {
    return std::find(options.quantities.begin(), options.quantities.end(), name) != options.quantities.end();
  };
  if (has_direction) AddQuantity(kNormalCurvature, options.quantities);
  if (is_asked(kNormalCurvature) && !has_direction) {
    throw CLI::ValidationError(kNormalCurvature, "needs --direction or --direction-columns");
  }
  if (flags.direction.empty()) return;
  std::array<double, 3> direction{};
  ParseDirection(flags.direction, direction);  // was checked
  options.curvature_direction = direction;
}

}  // namespace curv
