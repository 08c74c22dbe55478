#include "client/cli/doctor/findings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_format.h"

namespace curv {
namespace {

const char* WordOf(Verdict verdict) {
  static constexpr const char* kWords[] = {"ok", "warning", "fault"};
  return kWords[static_cast<size_t>(verdict)];
}

}  // namespace

void Findings::Ok(std::string check, std::string says) {
  all_.push_back({std::move(check), Verdict::kOk, std::move(says), ""});
}

void Findings::Warn(std::string check, std::string says, std::string remedy) {
  all_.push_back({std::move(check), Verdict::kWarning, std::move(says), std::move(remedy)});
}

void Findings::Fault(std::string check, std::string says, std::string remedy) {
  all_.push_back({std::move(check), Verdict::kFault, std::move(says), std::move(remedy)});
}

size_t Findings::Count(Verdict verdict) const {
  return static_cast<size_t>(
      std::count_if(all_.begin(), all_.end(), [verdict](const Finding& each) { return each.verdict == verdict; }));
}

std::string Findings::Text() const {
  std::string text;
  for (const Finding& each : all_) {
    absl::StrAppendFormat(&text, "  %-8s %-12s %s\n", WordOf(each.verdict), each.check, each.says);
    if (!each.remedy.empty()) absl::StrAppendFormat(&text, "  %-8s %-12s -> %s\n", "", "", each.remedy);
  }
  return text;
}

nlohmann::ordered_json Findings::Json() const {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& each : all_) {
    list.push_back(
        {{"check", each.check}, {"result", WordOf(each.verdict)}, {"message", each.says}, {"remedy", each.remedy}});
  }
  return list;
}

}  // namespace curv
