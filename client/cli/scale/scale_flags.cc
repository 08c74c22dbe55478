#include "client/cli/scale/scale_flags.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "client/cli/flags.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr uint32_t kMostNeighbors = 1'000'000;
constexpr uint32_t kLeastAutomatic = 16, kMostAutomatic = 2048;

// Reads LEAST:MOST; false if the text is none.
bool ParseRange(const std::string& text, AutomaticScale& scale) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return false;
  if (!ParseNumber(text.substr(0, colon), scale.least_neighbor_count)) return false;
  if (!ParseNumber(text.substr(colon + 1), scale.most_neighbor_count)) return false;
  return scale.least_neighbor_count >= kLeastAutomatic && scale.least_neighbor_count <= scale.most_neighbor_count &&
         scale.most_neighbor_count <= kMostAutomatic;
}

CLI::Validator CountRange() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        AutomaticScale scale;
        if (ParseRange(text, scale)) return "";
        return absl::StrCat("\"", text, "\" must be LEAST:MOST, whole numbers from ", kLeastAutomatic, " to ",
                            kMostAutomatic);
      },
      "");
}

}  // namespace

void AddScaleFlags(CLI::App& command, ScaleFlags& flags) {
  command.add_flag("--auto", flags.automatic,
                   "let the server choose estimator and scale by noise and detail: --estimator=auto --k=auto");
  auto* k =
      command
          .add_option("--k", flags.k,
                      "points in a neighborhood, itself included; auto: as noise and detail ask for, at each point")
          ->check(AutoOrCount(kMostNeighbors))
          ->option_text("COUNT [50]");
  command.add_option("--radius", flags.radius, "radius of the neighborhoods instead, in the cloud's length unit")
      ->check(FinitePositive())
      ->excludes(k)
      ->option_text("LENGTH");
  command.add_option("--k-range", flags.range, "of --k=auto: the fewest and the most points [16:2048]")
      ->check(CountRange())
      ->option_text("LEAST:MOST");
  command.add_option("--max-radius", flags.max_radius, "of --k=auto: how far an estimate looks at most [any distance]")
      ->check(FinitePositive())
      ->option_text("LENGTH");
  command.add_flag("--per-cloud", flags.per_cloud, "of --k=auto: the same choice for all points");
}

void ApplyScale(const ScaleFlags& flags, EstimateOptions& options) {
  if (flags.automatic) {
    if (!flags.k.empty() || flags.radius > 0.0) throw CLI::ValidationError("--auto", "excludes --k and --radius");
    options.estimator = Estimator::kAuto;
  }
  const bool leaves_open = options.estimator == Estimator::kAuto && flags.k.empty();
  if (options.estimator == Estimator::kAuto && flags.radius > 0.0) {
    throw CLI::ValidationError("--estimator=auto", "excludes --radius: try --max-radius");
  }
  if (!leaves_open && flags.k != "auto") {
    if (!flags.range.empty() || flags.max_radius > 0.0 || flags.per_cloud) {
      throw CLI::ValidationError("--k-range, --max-radius and --per-cloud", "need --auto or --k=auto");
    }
    if (flags.radius > 0.0) options.radius = flags.radius;
    if (!flags.k.empty()) ParseNumber(flags.k, options.neighbor_count);  // was checked
    return;
  }
  AutomaticScale scale;
  if (!flags.range.empty()) ParseRange(flags.range, scale);  // was checked
  scale.max_radius = flags.max_radius;
  scale.per_cloud = flags.per_cloud;
  options.automatic_scale = scale;
}

}  // namespace curv
