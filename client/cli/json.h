// Prints JSON for programs that call curv.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace curv {

// Returns `json` in one line, with the line's end. Numbers that are not finite become null; bytes that are not UTF-8,
// which a file's name can hold, become U+FFFD.
inline std::string ToJsonLine(const nlohmann::ordered_json& json) {
  return json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace curv
