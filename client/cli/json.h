// JSON for programs that call curv.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace curv {

// Returns `json` in one line, with the line's end. Numbers that are not finite become null; bytes that are not UTF-8,
// which a file's name can hold, become U+FFFD.
std::string ToJsonLine(const nlohmann::ordered_json& json);

}  // namespace curv
