#include "client/report/laz_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/io/las/laz_points.h"
#include "client/io/point_status.h"
#include "client/report/page_parts.h"
#include "client/report/report_quantity.h"

namespace curv {
namespace {

using Json = nlohmann::ordered_json;

template <typename... Parts>
absl::Status Error(const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat(parts...));
}

absl::Status CheckSizes(std::string_view file, const LasHeader& header) {
  constexpr char kRemedy[] =
      ". Make plain LAS of it, with \"laszip -i in.laz -o out.las\" or \"pdal translate in.laz out.las\"";
  if (header.points == 0) return Error("the file holds no points: expected point data records");
  if (file.size() > kMostLazBytes) {
    return Error("the file has ", file.size(), " bytes: a page decompresses at most ", kMostLazBytes, kRemedy);
  }
  const uint64_t bytes = uint64_t{header.points} * header.record_bytes;
  if (bytes > kMostDecompressedBytes) {
    return Error("the points take ", bytes, " bytes once they are decompressed: a page has room for ",
                 kMostDecompressedBytes, kRemedy);
  }
  return absl::OkStatus();
}

absl::Status CheckBox(std::string_view file) {
  const LasBox box = BoxOfHeader(file);
  for (size_t axis = 0; axis < 3; ++axis) {
    const bool is_box =
        std::isfinite(box.low[axis]) && std::isfinite(box.high[axis]) && box.low[axis] <= box.high[axis];
    if (is_box) continue;
    return Error("the bounding box goes from ", box.low[axis], " to ", box.high[axis], " along ",
                 std::string(1, "XYZ"[axis]), ": expected finite numbers, the least first");
  }
  return absl::OkStatus();
}

absl::Status CheckForCodec(std::string_view file, const LasHeader& header) {
  const unsigned minor_version = header.frame.minor_version, format = header.frame.point_format;
  if (minor_version < 2) {
    return Error("the version is 1.", minor_version, ": the page decompresses points of LAS 1.2 to 1.4");
  }
  if (format > 8 || format == 4 || format == 5) {
    return Error("the point data record format is ", format, ": the page decompresses 0 to 3 and 6 to 8");
  }
  if (header.chunk_points == 0) {
    return Error(
        "the record \"laszip encoded\" 22204 is missing or tells of chunks without points: it must say how the "
        "points are compressed");
  }
  return CheckChunkTable(file, header.points, header.chunk_points);
}

Json FieldsJson(const std::vector<LasField>& fields) {
  Json json = Json::array();
  for (const LasField& field : fields) {
    Json one = {{"name", field.name}, {"type", static_cast<int>(field.type)}, {"at", field.offset}};
    if (field.bits != 0) one.update({{"firstBit", field.first_bit}, {"bits", field.bits}});
    if (field.scaling.has_value()) {
      one["scaling"] = {{"scale", field.scaling->scale}, {"offset", field.scaling->offset}};
      if (field.scaling->no_data.has_value()) one["scaling"]["noData"] = *field.scaling->no_data;
    }
    json.push_back(std::move(one));
  }
  return json;
}

Json KnownJson() {
  Json json = Json::array();
  for (const KnownColumn& known : KnownColumns()) {
    json.push_back({{"column", known.column},
                    {"title", known.title},
                    {"exponent", known.length_exponent},
                    {"isCurvature", known.is_curvature},
                    {"signed", known.is_signed}});
  }
  return json;
}

Json LayoutJson(const LazFile& file) {
  const LasHeader& header = file.layout.header;
  const LasBox box = BoxOfHeader(file.bytes);
  Json axes = Json::array();
  for (const LasAxis& axis : header.frame.axes) axes.push_back({{"scale", axis.scale}, {"offset", axis.offset}});
  return {{"recordBytes", header.record_bytes},
          {"axes", axes},
          {"low", box.low},
          {"high", box.high},
          {"fields", FieldsJson(file.layout.fields)}};
}

// The report as far as it is known before the points are: the page adds the rest.
Json ReportJson(const LazFile& file, const ReportOptions& options) {
  Json words = Json::array();
  for (const std::string_view word : kStatusWords) words.push_back(std::string(word));
  return {{"title", options.title},
          {"unit", options.unit},
          {"up", options.up_axis.has_value() ? Json(std::string(1, *options.up_axis)) : Json(nullptr)},
          {"quantity", options.quantity},
          {"points", file.layout.header.points},
          {"percents", kReportPercents},
          {"notes", file.layout.notes},
          {"laz",
           {{"layout", LayoutJson(file)},
            {"mostPoints", options.most_points},
            {"mostQuantities", kMostQuantities},
            {"fewestQuantities", kFewestQuantities},
            {"mostValues", kMostValues},
            {"known", KnownJson()},
            {"noQuantities", NamesOfNoQuantity()},
            {"statusWords", words},
            {"withheldNote", kWithheldNote}}}};
}

}  // namespace

absl::StatusOr<LazFile> ReadLazFile(std::string bytes) {
  absl::StatusOr<LasLayout> layout = ReadLasLayout(bytes, Decompressor::kAnother);
  if (!layout.ok()) return layout.status();
  if (absl::Status status = CheckSizes(bytes, layout->header); !status.ok()) return status;
  if (absl::Status status = CheckForCodec(bytes, layout->header); !status.ok()) return status;
  if (absl::Status status = CheckBox(bytes); !status.ok()) return status;
  return LazFile{.bytes = std::move(bytes), .layout = *std::move(layout)};
}

bool IsShownInReports(const LazFile& file, const std::string& column) {
  const std::vector<std::string> others = NamesOfNoQuantity();
  if (column != "status" && std::find(others.begin(), others.end(), column) != others.end()) return false;
  // Integers of 64 bits may become two columns, which only their values tell.
  const auto is_it = [&](const LasField& field) {
    return field.name == column ||
           (field.is_wide() && (field.name + "_low" == column || field.name + "_high" == column));
  };
  return std::any_of(file.layout.fields.begin(), file.layout.fields.end(), is_it);
}

std::string MakeLazPage(const LazFile& file, const ReportOptions& options) {
  return FillPage(
      {.has_codec = true, .report = ScriptJson(ReportJson(file, options)), .points = absl::Base64Escape(file.bytes)});
}

void ServeLaz(LazFile file, const ReportOptions& options, uint64_t generation, bool watches, ReportShelf& shelf) {
  Json json = ReportJson(file, options);
  json["generation"] = generation;
  json["watches"] = watches;
  const auto bytes = std::make_shared<GrowingBytes>(file.bytes.size());
  bytes->Append(std::move(file.bytes));
  shelf.Put({.generation = generation, .report = ScriptJson(json), .points = bytes});
}

}  // namespace curv
