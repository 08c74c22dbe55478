#include "client/cli/json.h"

#include <nlohmann/json.hpp>

namespace curv {

std::string ToJsonLine(const nlohmann::ordered_json& json) {
  return json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace curv
