// Writes what an automatic estimate has chosen.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "client/curvature_client.h"

namespace curv {

// Returns several lines for people: the candidates with a weight, and for each estimator the best one without.
std::string ScaleText(const ScaleReport& report);
// Returns all that was judged.
nlohmann::ordered_json ScaleJson(const ScaleReport& report);

}  // namespace curv
