#include "client/cli/flags.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/io/text.h"

namespace curv {
namespace {

template <typename Condition>
CLI::Validator NumberThat(const std::string& what, Condition condition) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value;
        if (ParseNumber(text, value) && std::isfinite(value) && condition(value)) return "";
        return absl::StrCat("\"", text, "\" must be ", what);
      },
      "");
}

}  // namespace

CLI::Validator FinitePositive() {
  return NumberThat("a finite number above 0", [](double value) { return value > 0.0; });
}

CLI::Validator FiniteNotNegative() {
  return NumberThat("a finite number of 0 or more", [](double value) { return value >= 0.0; });
}

CLI::Validator Whole(uint64_t low, uint64_t high) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        uint64_t value;
        if (ParseNumber(text, value) && value >= low && value <= high) return "";
        return absl::StrCat("\"", text, "\" must be a whole number from ", low, " to ", high);
      },
      "");
}

CLI::Validator NotEmpty() {
  return CLI::Validator([](std::string& text) -> std::string { return text.empty() ? "must not be empty" : ""; }, "");
}

bool ParseRange(const std::string& text, double& low, double& high) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return false;
  const std::string_view view = text;
  return ParseNumber(view.substr(0, colon), low) && ParseNumber(view.substr(colon + 1), high) && std::isfinite(low) &&
         std::isfinite(high) && low < high && std::isfinite(high - low);
}

bool ParseSize(const std::string& text, int low, int high, int& width, int& height) {
  const size_t cross = text.find('x');
  if (cross == std::string::npos) return false;
  const std::string_view view = text;
  return ParseNumber(view.substr(0, cross), width) && ParseNumber(view.substr(cross + 1), height) && width >= low &&
         width <= high && height >= low && height <= high;
}

}  // namespace curv
