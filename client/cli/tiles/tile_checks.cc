#include "client/cli/tiles/tile_checks.h"

#include <algorithm>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"

namespace curv {

void CheckTileNormals(const NormalFlags& normals) {
  if (normals.source == NormalSource::kGiven) return;
  throw CLI::ValidationError(
      normals.source == NormalSource::kOrient ? "--orient" : "--normals",
      "the sides of normals follow from the whole cloud, which no tile has: curv normals, or curv orient, writes "
      "them into a file first");
}

void CheckTileQuantities(const QuantityFlags& quantities) {
  if (!quantities.direction.empty() || !quantities.direction_columns.empty()) {
    throw CLI::ValidationError(quantities.direction.empty() ? "--direction-columns" : "--direction",
                               "tiles take no directions");
  }
  for (const auto& [flag, words] : {std::pair("--quantities", &quantities.only), {"--also", &quantities.also}}) {
    const auto has = [words = words](const char* name) {
      return std::find(words->begin(), words->end(), name) != words->end();
    };
    for (const char* name : {"standard_errors", "chosen_neighbor_count", "estimator_weights"}) {
      if (!has(name)) continue;
      throw CLI::ValidationError(
          flag, absl::StrCat("tiles have no ", name, ": errors and choices follow from a sample of the whole cloud"));
    }
    if (has("normal_curvature")) {
      throw CLI::ValidationError(flag, "tiles have no normal_curvature: they take no directions");
    }
  }
}

}  // namespace curv
