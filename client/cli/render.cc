#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/cli/command.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/result_columns.h"
#include "client/cli/table_vectors.h"
#include "client/io/atomic_file.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/render/picture.h"

namespace curv {
namespace {

constexpr char kRenderExamples[] =
    "Examples:\n"
    "  curv render result.ply -o mean.png\n"
    "  curv render result.ply -o gaussian.png --quantity=gaussian --range=-0.034:0.119 --view=front --up=y\n"
    "Blue is below zero, red above, grey has no value. The default range is symmetric and holds 98 % of the values.";

struct RenderFlags {
  std::string input;
  std::string output;
  std::string quantity = "mean";
  std::string range;
  std::string view = "three-quarter";
  std::string up = "z";
  std::string size = "1200x900";
  std::string unit = "length unit";
  std::string format;
};

struct Drawing {
  std::string column;
  PictureOptions options;
};

// The column that holds the quantity: the estimate, or the truth of a file that was only generated, or the column of
// that very name.
absl::StatusOr<Drawing> ChooseColumn(const PointTable& table, const std::string& quantity,
                                     const std::string& length_unit) {
  const NamedQuantity* const named = FindQuantity(quantity);
  if (named == nullptr) {
    if (table.Find(quantity) != nullptr) return Drawing{quantity, {.title = quantity}};
    return absl::InvalidArgumentError(absl::StrCat("there is no column ", quantity, ": --quantity must be one of ",
                                                   kQuantityWords, ", or the name of a column"));
  }
  Drawing drawing{named->column,
                  {.title = named->title, .unit = absl::StrReplaceAll(named->unit, {{"%", length_unit}})}};
  if (table.Find(named->column) != nullptr) return drawing;
  if (table.Find(named->truth_column) == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("there is no column ", named->column,
                                                   ". Run curv estimate on the file first, or name another column "
                                                   "with --quantity"));
  }
  drawing.column = named->truth_column;
  drawing.options.title += " (exact)";
  return drawing;
}

absl::Status ReadFlags(const RenderFlags& flags, PictureOptions& options) {
  if (!flags.range.empty()) {
    double low, high;
    if (!ParseRange(flags.range, low, high)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--range: \"", flags.range, "\" must be LO:HI, two finite numbers with LO < HI and a finite difference"));
    }
    options.scale = ColorScale(low, high);
  }
  if (!ParseSize(flags.size, kMinPictureSide, kMaxPictureSide, options.width, options.height)) {
    return absl::InvalidArgumentError(absl::StrCat("--size: \"", flags.size, "\" must be WIDTHxHEIGHT, each from ",
                                                   kMinPictureSide, " to ", kMaxPictureSide));
  }
  absl::StatusOr<View> view = MakeView(flags.view, flags.up[0]);
  if (!view.ok()) return absl::InvalidArgumentError(absl::StrCat("--view: ", view.status().message()));
  options.view = *view;
  return absl::OkStatus();
}

absl::Status SavePng(const Image& image, const std::string& path) {
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->Append(EncodePng(image)); !status.ok()) return status;
  return file->Commit();
}

ExitCode Run(const RenderFlags& flags) {
  PictureOptions parsed;
  if (absl::Status status = ReadFlags(flags, parsed); !status.ok()) return Fail(ExitCode::kUsage, status);
  if (!absl::EndsWithIgnoreCase(flags.output, ".png")) {
    return Fail(ExitCode::kOutput, absl::StrCat(flags.output, ": pictures are written as .png"));
  }
  absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  const auto bad_input = [&](const absl::Status& status) {
    return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", status.message()));
  };
  if (absl::Status status = ExtractCloud(*table).status(); !status.ok()) return bad_input(status);
  absl::StatusOr<Drawing> drawing = ChooseColumn(*table, flags.quantity, flags.unit);
  if (!drawing.ok()) return bad_input(drawing.status());
  parsed.title = drawing->options.title;
  parsed.unit = drawing->options.unit;
  absl::StatusOr<Image> image =
      DrawPicture(VectorsOf(*table, ""), VectorsOf(*table, "n"), ValuesOf(*table, drawing->column), parsed);
  if (absl::IsFailedPrecondition(image.status())) return Fail(ExitCode::kOutput, image.status());
  if (!image.ok()) return bad_input(image.status());
  if (absl::Status status = SavePng(*image, flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  std::printf("%s: %s of %s\n", flags.output.c_str(), drawing->column.c_str(), flags.input.c_str());
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
  command->add_option("--quantity", flags->quantity, absl::StrCat(kQuantityWords, ", or the name of a column [mean]"))
      ->option_text("NAME");
  command->add_option("--range", flags->range, "values at the ends of the color scale")->option_text("LO:HI");
  command->add_option("--view", flags->view, absl::StrCat(kViewNames, " in degrees [three-quarter]"))
      ->option_text("VIEW");
  command->add_option("--up", flags->up, "axis that points up: z [default] or y")
      ->check(CLI::IsMember({"y", "z"}).description(""))
      ->option_text("AXIS");
  command->add_option("--size", flags->size, "of the picture in pixels [1200x900]")->option_text("WIDTHxHEIGHT");
  command->add_option("--unit", flags->unit, "the cloud's length unit, for the scale bar: mm makes it say 1/mm")
      ->option_text("NAME");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
