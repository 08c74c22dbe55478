// What `curv doctor` found about one server, in the order in which it looked.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace curv {

enum class Verdict { kOk, kWarning, kFault };

struct Finding {
  std::string check;  // "name", "connection", ...
  Verdict verdict = Verdict::kOk;
  std::string says;
  std::string remedy;  // what to do; none where nothing is wrong
};

class Findings {
 public:
  void Ok(std::string check, std::string says);
  void Warn(std::string check, std::string says, std::string remedy);
  void Fault(std::string check, std::string says, std::string remedy);

  const std::vector<Finding>& all() const { return all_; }
  size_t Count(Verdict verdict) const;

  // A line for each finding, with the remedy below it where there is one, each indented by two blanks.
  std::string Text() const;
  // An array of {"check", "result": "ok" | "warning" | "fault", "message", "remedy"}.
  nlohmann::ordered_json Json() const;

 private:
  std::vector<Finding> all_;
};

}  // namespace curv
