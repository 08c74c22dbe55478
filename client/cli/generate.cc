#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/files/save_output.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/numbers.h"
#include "client/io/table_file.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/surface.h"

namespace curv {
namespace {

constexpr char kGenerateExamples[] =
    "Example:\n"
    "  curv generate goursat --points=100000 --noise-position=0.05 --noise-normal=0.1 -o goursat.ply\n"
    "Surfaces: sphere of radius 1; torus of radii 6 and 2; cylinder of radius 1, height 4; saddle z = (x^2 - y^2) / "
    "2;\n"
    "goursat 0.03 (x^4 + y^4 + z^4) - 2 (x^2 + y^2 + z^2) = 8; ellipsoid of semi-axes 3, 2, 1; plane.\n"
    "Columns: x y z nx ny nz, then the exact values at the undisturbed point: true_mean true_gaussian true_k1 true_k2\n"
    "true_d1x true_d1y true_d1z true_d2x true_d2y true_d2z.";

// No sample is off by ten standard deviations: coordinates then fit into floats, and the squares of normals into
// doubles.
constexpr double kMostNoise = 1e37;

struct GenerateFlags {
  std::string surface;
  std::string output;
  SaveOptions save;
  uint64_t points = 0;
  uint64_t seed = 0;
  double position_noise = 0.0;
  double normal_noise = 0.0;
  bool doubles = false;
};

// Collects rows of doubles and turns them into columns of one type.
class ColumnBuilder {
 public:
  ColumnBuilder(bool doubles, size_t points) : doubles_(doubles), points_(points) {}

  // Adds a column of value(i) for each point i.
  template <typename Value>
  void Add(const std::string& name, const Value& value) {
    if (doubles_) {
      table_.Set({name, Fill<double>(value)});
    } else {
      table_.Set({name, Fill<float>(value)});
    }
  }
  // Adds the columns name + x, y and z.
  template <typename Value>
  void AddVector(const std::string& name, const Value& vector) {
    for (int axis = 0; axis < 3; ++axis) {
      Add(name + "xyz"[axis], [&](size_t i) { return vector(i)[axis]; });
    }
  }
  PointTable Release() { return std::move(table_); }

 private:
  template <typename Scalar, typename Value>
  std::vector<Scalar> Fill(const Value& value) const {
    std::vector<Scalar> values(points_);
    for (size_t i = 0; i < points_; ++i) values[i] = static_cast<Scalar>(value(i));
    return values;
  }

  bool doubles_;
  size_t points_;
  PointTable table_;
};

PointTable MakeTable(const Surface& surface, std::vector<Vec3> positions, const GenerateFlags& flags) {
  std::vector<SurfaceGeometry> truth;
  std::vector<Vec3> normals;
  truth.reserve(positions.size());
  for (const Vec3& position : positions) {
    truth.push_back(surface.At(position));
    normals.push_back(truth.back().normal);
  }
  AddPositionNoise(flags.position_noise, flags.seed, positions);
  if (flags.normal_noise > 0.0) AddNormalNoise(flags.normal_noise, flags.seed, normals);

  ColumnBuilder columns(flags.doubles, positions.size());
  columns.AddVector("", [&](size_t i) { return positions[i]; });
  columns.AddVector("n", [&](size_t i) { return normals[i]; });
  columns.Add("true_mean", [&](size_t i) { return truth[i].mean; });
  columns.Add("true_gaussian", [&](size_t i) { return truth[i].gaussian; });
  columns.Add("true_k1", [&](size_t i) { return truth[i].k1; });
  columns.Add("true_k2", [&](size_t i) { return truth[i].k2; });
  columns.AddVector("true_d1", [&](size_t i) { return truth[i].d1; });
  columns.AddVector("true_d2", [&](size_t i) { return truth[i].d2; });
  return columns.Release();
}

ExitCode Run(const GenerateFlags& flags) {
  if (const ExitCode code = CheckOutput(flags.output, flags.save); code != ExitCode::kOk) return code;
  absl::StatusOr<std::unique_ptr<Surface>> surface = MakeSurface(flags.surface);
  if (!surface.ok()) return Fail(ExitCode::kUsage, surface.status());
  absl::StatusOr<std::vector<Vec3>> positions = SampleEvenly(**surface, flags.points, flags.seed);
  if (!positions.ok()) return Fail(ExitCode::kUsage, positions.status());
  const PointTable table = MakeTable(**surface, *std::move(positions), flags);
  const UninterruptedWrite write(flags.output);
  if (absl::Status status = SaveTable(table, flags.output, flags.save); !status.ok())
    return Fail(ExitCode::kOutput, status);
  std::fprintf(SummaryStream(flags.output), "%s: %s of the surface %s\n", ShownOutput(flags.output).c_str(),
               CountOf(flags.points, "point").c_str(), flags.surface.c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddGenerate(CLI::App& app, Action& action) {
  auto flags = std::make_shared<GenerateFlags>();
  CLI::App* command = app.add_subcommand("generate", "Sample an analytic surface, with its exact curvature");
  command->footer(absl::StrCat(kGenerateExamples, "\n", kExitCodesHelp));
  const std::vector<std::string_view> names = SurfaceNames();
  command->add_option("surface", flags->surface, "sphere, torus, cylinder, saddle, goursat, ellipsoid or plane")
      ->required()
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())).description(""))
      ->option_text("SURFACE");
  command->add_option("--points", flags->points, "how many")
      ->required()
      ->check(Whole(1, kMaxSamplePoints))
      ->option_text("COUNT");
  command->add_option("--noise-position", flags->position_noise, "standard deviation of each coordinate, length unit")
      ->check(UpTo(kMostNoise))
      ->option_text("SIGMA [0]");
  command->add_option("--noise-normal", flags->normal_noise, "standard deviation of each component; then normalized")
      ->check(UpTo(kMostNoise))
      ->option_text("SIGMA [0]");
  command->add_option("--seed", flags->seed, "of sampling and noise; the same seed gives the same file")
      ->check(Whole(0, ~uint64_t{0}))
      ->option_text("NUMBER [0]");
  command->add_flag("--double", flags->doubles, "64-bit columns instead of 32-bit");
  AddOutput(*command, flags->output, absl::StrCat("the cloud: ", kWritableFiles));
  AddOutputFormat(*command, flags->save);
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
