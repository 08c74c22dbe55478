#include "client/cli/scale/scale_flags.h"

#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "client/cli/flags.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr uint32_t kMostNeighbors = 1'000'000;
constexpr uint32_t kLeastAutomatic = 16, kMostAutomatic = 2048;

// Reads LEAST:MOST; false if the text is none, or out of bounds.
bool ParseCounts(const std::string& text, AutomaticScale& scale) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return false;
  if (!ParseNumber(text.substr(0, colon), scale.least_neighbor_count)) return false;
  if (!ParseNumber(text.substr(colon + 1), scale.most_neighbor_count)) return false;
  return scale.least_neighbor_count >= kLeastAutomatic && scale.least_neighbor_count <= scale.most_neighbor_count &&
         scale.most_neighbor_count <= kMostAutomatic;
}

CLI::Validator Counts() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        AutomaticScale scale;
        if (ParseCounts(text, scale)) return "";
        return absl::StrCat("\"", text, "\" must be LEAST:MOST, whole numbers with ", kLeastAutomatic,
                            " <= LEAST <= MOST <= ", kMostAutomatic);
      },
      "");
}

constexpr size_t kMostScales = 16;
constexpr uint32_t kLeastNeighbors = 4;

// Reads several counts with commas between; false if they are none, or do not ascend within bounds.
bool ParseList(const std::string& text, std::vector<uint32_t>& counts) {
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    uint32_t count;
    if (!ParseNumber(std::string(part), count) || count < kLeastNeighbors || count > kMostNeighbors) return false;
    if (!counts.empty() && count <= counts.back()) return false;
    counts.push_back(count);
  }
  return counts.size() <= kMostScales;
}

bool IsList(const std::string& text) { return text.find(',') != std::string::npos; }

CLI::Validator AutoOrCounts() {
  return CLI::Validator(
      [one = AutoOrCount(kMostNeighbors)](std::string& text) -> std::string {
        std::vector<uint32_t> counts;
        if (!IsList(text)) return one(text);
        if (ParseList(text, counts)) return "";
        return absl::StrCat("\"", text, "\" must be at most ", kMostScales, " whole numbers from ", kLeastNeighbors,
                            " to ", kMostNeighbors, " that ascend, with commas between");
      },
      "");
}

// Which of the flags that need an automatic scale is given; nullptr if none.
const char* BoundOf(const ScaleFlags& flags) {
  if (!flags.range.empty()) return "--k-range";
  if (flags.max_radius > 0.0) return "--max-radius";
  return flags.per_cloud ? "--per-cloud" : nullptr;
}

}  // namespace

void AddScaleFlags(CLI::App& command, ScaleFlags& flags) {
  CLI::Option* automatic = command.add_flag(
      "--auto", flags.automatic,
      "choose estimators and neighborhoods by the cloud's noise and detail: short for --estimator=auto "
      "--k=auto");
  CLI::Option* k = command
                       .add_option("--k", flags.k,
                                   "points in a neighborhood, itself included; several, as 16,64,256: columns for each "
                                   "(avg-hexagram, normal-regression); auto: chosen at each point by noise and detail "
                                   "[50; with --estimator=auto: auto]")
                       ->check(AutoOrCounts())
                       ->option_text("COUNT");
  CLI::Option* radius =
      command.add_option("--radius", flags.radius, "radius of the neighborhoods instead, in the cloud's length unit")
          ->check(FinitePositive())
          ->excludes(k)
          ->option_text("LENGTH");
  automatic->excludes(command.get_option("--estimator"))->excludes(k)->excludes(radius);
  command.add_option("--k-range", flags.range, "with --k=auto: the fewest and the most points [16:2048]")
      ->check(Counts())
      ->option_text("LEAST:MOST");
  command
      .add_option("--max-radius", flags.max_radius,
                  "with --k=auto: how far an estimate looks at most, in the cloud's length unit [any distance]")
      ->check(FinitePositive())
      ->option_text("LENGTH");
  command.add_flag("--per-cloud", flags.per_cloud, "with --k=auto: one choice for all points");
}

void ApplyScale(const ScaleFlags& flags, EstimateOptions& options) {
  if (flags.automatic) options.estimator = Estimator::kAuto;
  if (options.estimator == Estimator::kAuto && flags.radius > 0.0) {
    throw CLI::ValidationError("--radius", "does not go with --estimator=auto; try --max-radius");
  }
  if (flags.k == "auto" || (options.estimator == Estimator::kAuto && flags.k.empty())) {
    AutomaticScale& scale = options.automatic_scale.emplace();
    if (!flags.range.empty()) ParseCounts(flags.range, scale);  // was checked
    scale.max_radius = flags.max_radius;
    scale.per_cloud = flags.per_cloud;
    return;
  }
  if (const char* bound = BoundOf(flags)) throw CLI::ValidationError(bound, "needs --auto or --k=auto");
  if (flags.radius > 0.0) options.radius = flags.radius;
  if (IsList(flags.k)) {
    ParseList(flags.k, options.neighbor_counts);  // was checked
    return;
  }
  if (!flags.k.empty()) ParseNumber(flags.k, options.neighbor_count);  // was checked
}

}  // namespace curv
