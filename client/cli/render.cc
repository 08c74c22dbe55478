#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cli/command.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/result_columns.h"
#include "client/cli/table_vectors.h"
#include "client/io/atomic_file.h"
#include "client/io/oriented_cloud.h"
#include "client/io/point_status.h"
#include "client/io/table_file.h"
#include "client/render/camera.h"
#include "client/render/lettering.h"
#include "client/render/picture.h"
#include "client/render/pose.h"

namespace curv {
namespace {

constexpr size_t kMostPanels = 16;

constexpr char kRenderExamples[] =
    "Examples:\n"
    "  curv render result.ply -o mean.png\n"
    "  curv render result.ply -o all.png --quantity=mean,gaussian,k1,k2 --size=1600x1200\n"
    "  curv render result.ply -o directions.png --quantity=k2 --strokes=d1,d2\n"
    "  curv render result.ply -o gaussian.png --quantity=gaussian --range=-0.034:0.119 --view=front --up=y\n"
    "Blue is below zero, red above, grey has no value. The default range is symmetric and holds 98 % of the values.\n"
    "Without --up and --view both are chosen from the cloud: scans do not lie on their side, and what is open is seen\n"
    "from where it is open. The line that the command prints says what was chosen.";

struct RenderFlags {
  std::string input;
  std::string output;
  std::vector<std::string> quantities = {"mean"};
  std::vector<std::string> ranges;
  std::vector<std::string> strokes;
  std::string title;
  std::string view;
  std::string up;
  std::string size = "1200x900";
  std::string unit = "length unit";
  std::string format;
};

// The layer of a column, with the title of its quantity, and the neighbor count if it is of one of several, which no
// line breaks.
Layer LayerOfColumn(const PointTable& table, const std::string& column, const std::string& length_unit) {
  const std::string base = WithoutScale(column);
  Layer layer{.values = ValuesOf(table, column), .title = column};
  if (const NamedQuantity* const named = QuantityOfColumn(base); named != nullptr) {
    layer.title = named->title;
    if (base != column)
      absl::StrAppend(&layer.title, ", K\u00a0=\u00a0", column.substr(base.size() + sizeof("_k") - 1));
    layer.unit = absl::StrReplaceAll(named->unit, {{"%", length_unit}});
  }
  return layer;
}

bool HoldsResults(const PointTable& table) {
  return std::any_of(table.columns().begin(), table.columns().end(),
                     [](const Column& column) { return IsStatusName(column.name); });
}

// Says what to do about a column of results that is not there.
absl::Status NoColumn(const PointTable& table, const NamedQuantity& named) {
  std::string scales;
  for (const Column& column : table.columns()) {
    if (column.name == named.column || WithoutScale(column.name) != named.column) continue;
    absl::StrAppend(&scales, scales.empty() ? "" : ", ", column.name);
  }
  std::string what = absl::StrCat("there is no column ", named.column, ". ");
  if (!scales.empty()) {
    absl::StrAppend(&what, "Name one of ", scales, " with --quantity");
  } else {
    absl::StrAppend(&what, "Run curv estimate on the file first, or name another column with --quantity");
    if (table.Find(named.truth_column) != nullptr) absl::StrAppend(&what, ", such as ", named.truth_column);
  }
  return absl::InvalidArgumentError(what);
}

// The layer of the column that holds the quantity: the estimate, or the truth of a file that was only generated, or the
// column of that very name.
absl::StatusOr<Layer> MakeLayer(const PointTable& table, const std::string& quantity, const std::string& length_unit) {
  const NamedQuantity* const named = FindQuantity(quantity);
  if (named == nullptr) {
    if (table.Find(quantity) != nullptr) return LayerOfColumn(table, quantity, length_unit);
    return absl::InvalidArgumentError(absl::StrCat("there is no column ", quantity, ": --quantity must be one of ",
                                                   kQuantityWords, ", or the name of a column"));
  }
  Layer layer{.title = named->title, .unit = absl::StrReplaceAll(named->unit, {{"%", length_unit}})};
  if (table.Find(named->column) != nullptr) {
    layer.values = ValuesOf(table, named->column);
    return layer;
  }
  // Exact values in place of estimates would be taken for these.
  if (table.Find(named->truth_column) == nullptr || HoldsResults(table)) return NoColumn(table, *named);
  layer.values = ValuesOf(table, named->truth_column);
  layer.title += " (exact)";
  return layer;
}

// A layer for each quantity, without ranges.
absl::StatusOr<std::vector<Layer>> MakeLayers(const PointTable& table, const RenderFlags& flags) {
  std::vector<Layer> layers;
  for (const std::string& quantity : flags.quantities) {
    absl::StatusOr<Layer> layer = MakeLayer(table, quantity, flags.unit);
    if (!layer.ok()) return layer.status();
    if (!flags.title.empty()) layer->title = flags.title;
    layers.push_back(*std::move(layer));
  }
  return layers;
}

// The principal directions, estimated, or exact in a file that was only generated.
absl::StatusOr<std::vector<StrokeField>> MakeStrokes(const PointTable& table, const std::vector<std::string>& names) {
  std::vector<StrokeField> strokes;
  for (const std::string& name : names) {
    const auto has = [&](const std::string& prefix) {
      return table.Find(prefix + "x") != nullptr && table.Find(prefix + "y") != nullptr &&
             table.Find(prefix + "z") != nullptr;
    };
    const std::string prefix = has(name) || HoldsResults(table) ? name : "true_" + name;
    if (!has(prefix)) {
      return absl::InvalidArgumentError(absl::StrCat("there are no columns ", name, "x ", name, "y ", name,
                                                     "z for --strokes. curv estimate writes them unless --quantities "
                                                     "leaves them out"));
    }
    strokes.push_back({.name = name == "d1" ? "d\u2081" : "d\u2082", .directions = VectorsOf(table, prefix)});
  }
  return strokes;
}

// One range for all quantities, or one for each; none, if none was given.
absl::StatusOr<std::vector<ColorScale>> ReadRanges(const RenderFlags& flags) {
  std::vector<ColorScale> scales;
  for (const std::string& range : flags.ranges) {
    double low, high;
    if (!ParseRange(range, low, high)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--range: \"", range, "\" must be LO:HI, two finite numbers with LO < HI and a finite difference"));
    }
    scales.emplace_back(low, high);
  }
  if (scales.size() > 1 && scales.size() != flags.quantities.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--range: there are ", scales.size(), " ranges for ", flags.quantities.size(),
        flags.quantities.size() == 1 ? " quantity" : " quantities", ": give one for all, or one for each"));
  }
  return scales;
}

absl::Status ReadFlags(const RenderFlags& flags, PictureOptions& options) {
  if (flags.quantities.size() > kMostPanels) {
    return absl::InvalidArgumentError(
        absl::StrCat("--quantity: there are ", flags.quantities.size(), " quantities: at most ", kMostPanels));
  }
  if (!ParseSize(flags.size, kMinPictureSide, kMaxPictureSide, options.width, options.height)) {
    return absl::InvalidArgumentError(absl::StrCat("--size: \"", flags.size, "\" must be WIDTHxHEIGHT, each from ",
                                                   kMinPictureSide, " to ", kMaxPictureSide));
  }
  if (flags.view.empty()) return absl::OkStatus();
  const absl::StatusOr<View> view = MakeView(flags.view, 'z');
  if (!view.ok()) return absl::InvalidArgumentError(absl::StrCat("--view: ", view.status().message()));
  return absl::OkStatus();
}

// The view that was asked for, as far as it was, and in words what was chosen; "" if nothing was.
std::pair<View, std::string> ChooseView(const RenderFlags& flags, const std::vector<Vec3>& positions,
                                        const std::vector<Vec3>& normals) {
  if (!flags.view.empty() && !flags.up.empty()) return {*MakeView(flags.view, flags.up[0]), ""};
  const Pose pose = ChoosePose(positions, normals, flags.up.empty() ? std::nullopt : std::optional(flags.up[0]));
  const std::string view = flags.view.empty() ? absl::StrCat(pose.azimuth, ":", pose.elevation) : flags.view;
  std::string words = absl::StrCat(", --up=", std::string(1, pose.up_axis));
  if (flags.up.empty() && *pose.reason != '\0') absl::StrAppend(&words, " (", pose.reason, ")");
  return {*MakeView(view, pose.up_axis), absl::StrCat(words, " --view=", view)};
}

absl::Status SavePng(const Image& image, const std::string& path) {
  const UninterruptedWrite write(path);
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->Append(EncodePng(image)); !status.ok()) return status;
  return file->Commit();
}

// Tells of texts that the picture cannot show as they should look.
void NoteLettering(const std::vector<Layer>& layers) {
  if (!CheckFonts().ok()) return;  // where letters are needed, DrawPicture refuses
  std::set<std::string> problems;
  for (const Layer& layer : layers) problems.insert({LetteringProblem(layer.title), LetteringProblem(layer.unit)});
  for (const std::string& problem : problems) {
    if (!problem.empty()) PrintNote(problem);
  }
}

ExitCode Run(const RenderFlags& flags) {
  PictureOptions options;
  if (absl::Status status = ReadFlags(flags, options); !status.ok()) return Fail(ExitCode::kUsage, status);
  const absl::StatusOr<std::vector<ColorScale>> scales = ReadRanges(flags);
  if (!scales.ok()) return Fail(ExitCode::kUsage, scales.status());
  if (!absl::EndsWithIgnoreCase(flags.output, ".png")) {
    return Fail(ExitCode::kOutput, absl::StrCat(flags.output, ": pictures are written as .png"));
  }
  absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  const auto bad_input = [&](const absl::Status& status) {
    return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", status.message()));
  };
  if (absl::Status status = ExtractCloud(*table).status(); !status.ok()) return bad_input(status);
  absl::StatusOr<std::vector<Layer>> layers = MakeLayers(*table, flags);
  if (!layers.ok()) return bad_input(layers.status());
  for (size_t l = 0; l < layers->size() && !scales->empty(); ++l) {
    (*layers)[l].scale = scales->size() == 1 ? scales->front() : (*scales)[l];
  }
  absl::StatusOr<std::vector<StrokeField>> strokes = MakeStrokes(*table, flags.strokes);
  if (!strokes.ok()) return bad_input(strokes.status());
  options.strokes = *std::move(strokes);
  const std::vector<Vec3> positions = VectorsOf(*table, ""), normals = VectorsOf(*table, "n");
  std::string chosen;
  std::tie(options.view, chosen) = ChooseView(flags, positions, normals);
  NoteLettering(*layers);
  absl::StatusOr<Image> image = DrawPicture(positions, normals, *layers, options);
  if (absl::IsFailedPrecondition(image.status())) return Fail(ExitCode::kOutput, image.status());
  if (!image.ok()) return bad_input(image.status());
  if (absl::Status status = SavePng(*image, flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  std::printf("%s: %s of %s%s\n", ShownOutput(flags.output).c_str(), absl::StrJoin(flags.quantities, ", ").c_str(),
              ShownInput(flags.input).c_str(), chosen.c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddRender(CLI::App& app, Action& action) {
  auto flags = std::make_shared<RenderFlags>();
  CLI::App* command = app.add_subcommand("render", "Draw a result as a picture, colored by curvature");
  command->footer(absl::StrCat(kRenderExamples, "\n", kExitCodesHelp));
  command->add_option("result", flags->input, "a result of curv estimate, or a cloud of curv generate")
      ->required()
      ->option_text("RESULT");
  AddInputFormat(*command, flags->format);
  command->add_option("-o,--output", flags->output, "the picture: .png")->required()->option_text("PNG");
  command
      ->add_option("--quantity", flags->quantities,
                   absl::StrCat(kQuantityWords, ", or the names of columns: a panel for each [mean]"))
      ->delimiter(',')
      ->allow_extra_args(false)
      ->option_text("NAME,...");
  command->add_option("--range", flags->ranges, "values at the ends of the color scale, of all panels or of each")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->option_text("LO:HI,...");
  command->add_option("--strokes", flags->strokes, "draw principal directions: d1 (along k1), d2 (along k2), or both")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"d1", "d2"}).description(""))
      ->option_text("NAME,...");
  command->add_option("--title", flags->title, "of the color scale, in any language that a font has [the quantity]")
      ->option_text("TEXT");
  command->add_option("--view", flags->view, absl::StrCat(kViewNames, " in degrees [chosen from the cloud]"))
      ->option_text("VIEW");
  command->add_option("--up", flags->up, "axis that points up: y or z [chosen from the cloud]")
      ->check(CLI::IsMember({"y", "z"}).description(""))
      ->option_text("AXIS");
  command->add_option("--size", flags->size, "of the picture in pixels [1200x900]")->option_text("WIDTHxHEIGHT");
  command->add_option("--unit", flags->unit, "the cloud's length unit, for the scale bar: mm makes it say 1/mm")
      ->option_text("NAME");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
