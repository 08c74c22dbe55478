#include "client/report/page_parts.h"

#include <cstddef>
#include <utility>

#include "absl/strings/str_replace.h"
#include "client/report/page_template.h"

namespace curv {

std::string ScriptJson(const nlohmann::ordered_json& json) {
  using Json = nlohmann::ordered_json;
  return absl::StrReplaceAll(json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace),
                             {{"<", "\\u003c"}});
}

std::string FillPage(const PageParts& parts) {
  const std::string_view page = PageTemplate();
  const std::string_view codec = parts.has_codec ? LazCodec() : "\n";
  const size_t line = codec.find('\n');
  std::string filled;
  filled.reserve(page.size() + codec.size() + parts.report.size() + parts.points.size());
  size_t at = 0;
  for (const auto& [place, text] :
       {std::pair<std::string_view, std::string_view>("@curv-connect@", parts.may_ask ? "connect-src 'self'; " : ""),
        {"@curv-codec-policy@", codec.substr(0, line)},
        {"@curv-report@", parts.report},
        {"@curv-points@", parts.points},
        {"@curv-codec@", codec.substr(line + 1)}}) {
    const size_t found = page.find(place, at);
    filled.append(page.substr(at, found - at)).append(text);
    at = found + place.size();
  }
  filled.append(page.substr(at));
  return filled;
}

}  // namespace curv
