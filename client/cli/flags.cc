#include "client/cli/flags.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/match.h"
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

CLI::Validator UpTo(double most) {
  return NumberThat(absl::StrCat("a number from 0 to ", most),
                    [most](double value) { return value >= 0.0 && value <= most; });
}

CLI::Validator Whole(uint64_t low, uint64_t high) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        uint64_t value;
        // CLI11 would read 0100 as 64, by the rules of C.
        if (ParseNumber(text, value) && value >= low && value <= high && text == absl::StrCat(value)) return "";
        return absl::StrCat("\"", text, "\" must be a whole number from ", low, " to ", high,
                            text.size() > 1 && text.front() == '0' ? ", without zeros before it" : "");
      },
      "");
}

CLI::Validator ByteSize(uint64_t least) {
  return CLI::Validator(
      [=, with_unit = CLI::AsSizeValue(false)](std::string& text) -> std::string {
        std::string bytes = text;
        uint64_t value;
        try {
          if (with_unit(bytes).empty() && ParseNumber(bytes, value) && value >= least) {
            text = bytes;
            return "";
          }
        } catch (const CLI::ValidationError&) {  // of a unit that there is not
        }
        return absl::StrCat("\"", text, "\" must be a size of ", least >> 20,
                            "MiB or more, such as 512MiB; a number without a unit counts bytes");
      },
      "");
}

CLI::Validator AutoOrCount(uint32_t most) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        uint32_t count;
        if (text == "auto" || (ParseNumber(text, count) && count >= 4 && count <= most)) return "";
        return absl::StrCat("\"", text, "\" must be auto or a whole number from 4 to ", most);
      },
      "");
}

CLI::Validator NotEmpty() {
  return CLI::Validator([](std::string& text) -> std::string { return text.empty() ? "must not be empty" : ""; }, "");
}

CLI::Validator FiniteVector() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        std::array<double, 3> vector;
        return ParseVector(text, vector) ? "" : absl::StrCat("\"", text, "\" must be three finite numbers: X,Y,Z");
      },
      "");
}

CLI::Validator Direction() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        std::array<double, 3> direction;
        if (ParseDirection(text, direction)) return "";
        return absl::StrCat("\"", text, "\" must be x, y, z, -x, -y, -z or three finite numbers, not all 0: X,Y,Z");
      },
      "");
}

void RefuseValuesOfSwitches(CLI::App& app) {
  const CLI::Validator yes_or_no(
      [](std::string& text) -> std::string {
        for (const char* word : {"true", "false", "yes", "no", "on", "off", "1", "0"}) {
          if (absl::EqualsIgnoreCase(text, word)) return "";
        }
        return absl::StrCat("\"", text, "\" must be true or false, or not be given: the flag takes no other value");
      },
      "");
  for (CLI::Option* option : app.get_options()) {
    // Flags such as --up{z} have a value of their own where none is given.
    const std::vector<std::string>& names = option->get_lnames();
    if (option->get_items_expected_max() > 0 || (!names.empty() && option->check_fname(names.front()))) continue;
    option->check(yes_or_no);
  }
  for (CLI::App* command : app.get_subcommands({})) RefuseValuesOfSwitches(*command);
}

bool ParseVector(const std::string& text, std::array<double, 3>& vector) {
  std::string_view rest = text;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t comma = axis < 2 ? rest.find(',') : rest.size();
    if (comma == std::string_view::npos) return false;
    if (!ParseNumber(rest.substr(0, comma), vector[axis]) || !std::isfinite(vector[axis])) return false;
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return true;
}

bool ParseDirection(const std::string& text, std::array<double, 3>& direction) {
  constexpr std::string_view kAxes = "xyz";
  const bool is_negative = !text.empty() && text.front() == '-';
  const size_t axis = text.size() == (is_negative ? 2 : 1) ? kAxes.find(text.back()) : std::string_view::npos;
  if (axis != std::string_view::npos) {
    direction = {};
    direction[axis] = is_negative ? -1.0 : 1.0;
    return true;
  }
  return ParseVector(text, direction) && direction != std::array<double, 3>{};
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
