// Says what was found out about normals, for people and for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "client/curvature_client.h"

namespace curv {

// "normals by jet-4 of 24 points, noise 0.0012; 1 piece, closed, certificate 0.004; 3 points have none".
std::string NormalsText(const NormalsReport& report);
nlohmann::ordered_json NormalsJson(const NormalsReport& report);

nlohmann::ordered_json WarningsJson(const EstimateSummary& summary);

}  // namespace curv
