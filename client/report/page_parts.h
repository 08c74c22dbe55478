// Puts the page of a report together.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace curv {

// JSON for a script element: it ends at the first `</script`, so that no `<` stands in it.
std::string ScriptJson(const nlohmann::ordered_json& json);

// What goes into the page's places (page_template.h).
struct PageParts {
  bool may_ask = false;    // whether it may send requests to where it came from
  bool has_codec = false;  // whether it can decompress LAZ
  std::string_view report = {};
  std::string_view points = {};  // without `<`
};

std::string FillPage(const PageParts& parts);

}  // namespace curv
