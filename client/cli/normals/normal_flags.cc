#include "client/cli/normals/normal_flags.h"

#include <array>
#include <variant>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/flags.h"
#include "client/io/oriented_cloud.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr uint32_t kMostNormalNeighbors = 1'000'000;

std::array<double, 3> VectorOf(const std::string& text) {
  std::array<double, 3> vector{};
  ParseVector(text, vector);  // was checked
  return vector;
}

}  // namespace

void AddSourceFlags(CLI::App& command, NormalFlags& flags) {
  CLI::Option* normals =
      command
          .add_option_function<std::string>(
              "--normals",
              [&flags](const std::string& source) {
                flags.source = source == "estimate" ? NormalSource::kEstimate
                               : source == "orient" ? NormalSource::kOrient
                                                    : NormalSource::kGiven;
              },
              "given [default]: those of the file, which point outward; orient: those of the file, turned to one side; "
              "estimate: made of the positions")
          ->check(CLI::IsMember({"given", "orient", "estimate"}).description(""))
          ->option_text("SOURCE");
  command
      .add_flag_callback(
          "--orient", [&flags] { flags.source = NormalSource::kOrient; }, "the same as --normals=orient")
      ->excludes(normals);
}

void CheckSource(const NormalFlags& flags) {
  if (flags.source == NormalSource::kGiven && flags.ChoosesSide()) {
    throw CLI::ValidationError("--viewpoint, --up, --closed and --consistent",
                               "need --normals=orient or --normals=estimate");
  }
  if (flags.source != NormalSource::kEstimate && flags.ChoosesMethod()) {
    throw CLI::ValidationError("--normal-method, --normal-k and --normal-radius", "need --normals=estimate");
  }
}

void AddSideFlags(CLI::App& command, NormalFlags& flags) {
  CLI::Option* consistent = command.add_flag(
      "--consistent", flags.consistent,
      "normals of neighbors agree, closed pieces are seen from outside [unless the file has viewpoints]");
  CLI::Option* closed =
      command.add_flag("--closed", flags.closed,
                       "likewise where all surfaces are closed, whatever holes they have: all normals "
                       "point outward");
  CLI::Option* viewpoint =
      command.add_option("--viewpoint", flags.viewpoint, "normals point to where the surface was seen from")
          ->check(FiniteVector())
          ->option_text("X,Y,Z");
  CLI::Option* up = command.add_flag("--up{z}", flags.up, "no normal points against an axis, or X,Y,Z [z]: --up=0,1,0")
                        ->check(Direction());
  for (CLI::Option* one : {consistent, closed, viewpoint, up}) {
    for (CLI::Option* other : {consistent, closed, viewpoint, up}) {
      if (one != other) one->excludes(other);
    }
  }
}

void AddMethodFlags(CLI::App& command, const std::string& prefix, NormalFlags& flags) {
  command
      .add_option(absl::StrCat("--", prefix, "method"), flags.method,
                  "how normals are made: pca, jet-1, jet-2 or jet-4 [jet-2 or jet-4, as the points ask for]")
      ->check(CLI::IsMember({"pca", "jet-1", "jet-2", "jet-4"}).description(""))
      ->option_text("NAME");
  CLI::Option* k =
      command
          .add_option(absl::StrCat("--", prefix, "k"), flags.k,
                      "points that a normal is made of, itself included [auto: by the noise of the points]")
          ->check(AutoOrCount(kMostNormalNeighbors))
          ->option_text("COUNT");
  command
      .add_option(absl::StrCat("--", prefix, "radius"), flags.radius,
                  "radius around a point for its normal instead, in the cloud's length unit")
      ->check(FinitePositive())
      ->excludes(k)
      ->option_text("LENGTH");
}

NormalOptions OptionsFor(const NormalFlags& flags, const PointTable& table, std::string& note) {
  note.clear();
  NormalOptions options;
  options.source = flags.source;
  if (flags.source == NormalSource::kGiven) return options;
  if (!flags.method.empty()) options.method = NormalMethodOf(flags.method);
  if (flags.k != "auto") ParseNumber(flags.k, options.neighbor_count);
  if (flags.radius > 0.0) options.radius = flags.radius;
  if (flags.closed) options.sides = ConsistentSides{.closed = true};
  if (!flags.viewpoint.empty()) options.sides = SidesTowardViewpoint{VectorOf(flags.viewpoint)};
  if (!flags.up.empty()) {
    SidesAlongDirection along{};
    ParseDirection(flags.up, along.direction);
    options.sides = along;
  }
  if (flags.ChoosesSide()) return options;
  if (const auto columns = FindViewpoints(table)) {
    options.sides = SidesTowardViewpoints{};
    note = absl::StrCat("normals point to where each point was seen from, the columns ", (*columns)[0], " ",
                        (*columns)[1], " ", (*columns)[2], " (--consistent: not)");
  } else if (table.viewpoint.has_value()) {
    const std::array<double, 3>& v = *table.viewpoint;
    options.sides = SidesTowardViewpoint{v};
    note = absl::StrFormat("normals point to the viewpoint of the file, %.10g,%.10g,%.10g (--consistent: not)", v[0],
                           v[1], v[2]);
  }
  return options;
}

CloudNeeds NeedsOf(const NormalOptions& options) {
  return {.normals = options.source != NormalSource::kEstimate,
          .viewpoints =
              options.source != NormalSource::kGiven && std::holds_alternative<SidesTowardViewpoints>(options.sides)};
}

}  // namespace curv
