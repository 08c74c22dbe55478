#include "client/cli/estimate_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/command.h"
#include "client/cli/json.h"
#include "client/cli/normals/normals_text.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/cli/scale/scale_text.h"
#include "client/io/point_status.h"

namespace curv {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The columns of results whose values are summed up, where they were asked for.
constexpr const char* kSummedUp[] = {"mean_curvature", "gaussian_curvature", "k1", "k2", "shape_index",
                                     "curvedness",     "normal_curvature"};

// What a point may lack though its status is ok, and why.
constexpr std::pair<const char*, const char*> kMayLack[] = {
    {"shape_index", "k1 and k2 are 0 there"},
    {"normal_curvature", "the direction is along their normals"},
};

// Least, middle and largest of the finite values; NaN if there are none.
struct Spread {
  double low = kNaN;
  double median = kNaN;
  double high = kNaN;
};

Spread SpreadOf(const PointTable& table, const std::string& column) {
  std::vector<double> values = ValuesOf(table, column);
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return {};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  Spread spread{.low = *low, .high = *high};
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  spread.median = *middle;
  return spread;
}

std::vector<std::pair<const char*, double>> PhaseSeconds(const EstimateReport& report) {
  const EstimateSummary& s = report.summary;
  std::vector<std::pair<const char*, double>> seconds = {{"read", report.read_seconds},
                                                         {"receive", s.receive_seconds},
                                                         {"queue", s.queue_seconds},
                                                         {"index", s.index_seconds}};
  if (s.normals.has_value()) {
    seconds.emplace_back("normals", s.normals_seconds);
    seconds.emplace_back("orientation", s.orientation_seconds);
  }
  for (const auto& phase : {std::pair("estimate", s.estimate_seconds), std::pair("send", s.send_seconds),
                            std::pair("write", report.write_seconds),
                            std::pair("total", report.read_seconds + report.call_seconds + report.write_seconds)}) {
    seconds.emplace_back(phase);
  }
  return seconds;
}

std::string NeighborhoodText(const EstimateOptions& options) {
  if (!options.neighbor_counts.empty()) return absl::StrCat("K = ", absl::StrJoin(options.neighbor_counts, ", "));
  if (options.automatic_scale) return "K = auto";
  return options.radius ? absl::StrCat("radius ", ExactText(*options.radius))
                        : absl::StrFormat("K = %d", static_cast<int>(options.neighbor_count));
}

// Of the jets in use: the automatic choice knows those of degree 4.
uint32_t JetDegree(const EstimateOptions& options) {
  const bool is_automatic = options.automatic_scale || options.estimator == Estimator::kAuto;
  return options.jet_degree.value_or(is_automatic ? 4 : 2);
}

// A table of the quantities' spreads; nothing if the result has none of them.
void AppendRanges(const PointTable& result, const std::string& suffix, std::string& text) {
  bool has_header = false;
  for (const std::string name : kSummedUp) {
    const std::string column = name + suffix;
    if (result.Find(column) == nullptr) continue;
    if (!has_header) absl::StrAppendFormat(&text, "  %-22s %14s %14s %14s\n", "", "least", "median", "largest");
    has_header = true;
    const Spread spread = SpreadOf(result, column);
    absl::StrAppendFormat(&text, "  %-22s %14.6g %14.6g %14.6g\n", column, spread.low, spread.median, spread.high);
  }
}

void AppendLacks(const PointTable& result, const std::string& suffix, std::string& text) {
  for (const auto& [name, reason] : kMayLack) {
    if (result.Find(name + suffix) == nullptr) continue;
    const std::vector<double> values = ValuesOf(result, name + suffix);
    const std::vector<double> statuses = ValuesOf(result, "status" + suffix);
    constexpr auto kOk = static_cast<double>(PointStatus::kOk);
    uint64_t lacking = 0;
    for (size_t i = 0; i < values.size(); ++i) lacking += statuses[i] == kOk && std::isnan(values[i]);
    if (lacking == 0) continue;
    absl::StrAppend(&text, "  ", CountOf(lacking, "ok point"), " without ", name, suffix, ": ", reason, "\n");
  }
}

// At one of several scales.
StatusCounts CountStatuses(const PointTable& result, const std::string& suffix) {
  StatusCounts counts{};
  for (const double status : ValuesOf(result, "status" + suffix)) {
    ++counts[status < static_cast<double>(counts.size()) ? static_cast<size_t>(status) : 0];
  }
  return counts;
}

void AppendResults(const EstimateReport& report, const PointTable& result, std::string& text) {
  if (report.options.neighbor_counts.empty()) {
    absl::StrAppend(&text, StatusText(report.summary.status_counts));
    AppendRanges(result, "", text);
    return AppendLacks(result, "", text);
  }
  for (const uint32_t count : report.options.neighbor_counts) {
    absl::StrAppend(&text, "  K = ", count, "\n");
    absl::StrAppend(&text, StatusText(CountStatuses(result, ScaleSuffix(count))));
    AppendRanges(result, ScaleSuffix(count), text);
    AppendLacks(result, ScaleSuffix(count), text);
  }
}

nlohmann::ordered_json RangesJson(const PointTable& result, const std::string& suffix) {
  nlohmann::ordered_json ranges = nlohmann::ordered_json::object();
  for (const std::string name : kSummedUp) {
    if (result.Find(name + suffix) == nullptr) continue;
    const Spread spread = SpreadOf(result, name + suffix);
    ranges[name] = {{"least", spread.low}, {"median", spread.median}, {"largest", spread.high}};
  }
  return ranges;
}

// ", jet, K = 50"; nothing of calls for normals alone, which make no curvature.
std::string EstimateText(const EstimateOptions& options) {
  if (!AskForCurvature(options.quantities)) return "";
  return absl::StrCat(", ", std::string(EstimatorName(options.estimator)), ", ", NeighborhoodText(options));
}

// The results at each of several scales.
nlohmann::ordered_json ScalesJson(const EstimateReport& report, const PointTable& result) {
  nlohmann::ordered_json scales = nlohmann::ordered_json::array();
  for (const uint32_t count : report.options.neighbor_counts) {
    const std::string suffix = ScaleSuffix(count);
    scales.push_back({{"neighbor_count", count},
                      {"status", StatusJson(CountStatuses(result, suffix))},
                      {"ranges", RangesJson(result, suffix)}});
  }
  return scales;
}

}  // namespace

std::string StatusText(const StatusCounts& counts) {
  std::string text;
  for (size_t status = 1; status < kStatusWords.size(); ++status) {
    if (status > 1 && counts[status] == 0) continue;
    absl::StrAppendFormat(&text, "  %-22s %14s\n", std::string(kStatusWords[status]), WithCommas(counts[status]));
  }
  return text;
}

nlohmann::ordered_json StatusJson(const StatusCounts& counts) {
  nlohmann::ordered_json json;
  for (size_t status = 1; status < kStatusWords.size(); ++status) json[kStatusWords[status]] = counts[status];
  return json;
}

std::string SummaryText(const EstimateReport& report, const PointTable& result) {
  std::string text =
      absl::StrFormat("%s: %s%s, server %s\n", ShownInput(report.input), CountOf(report.summary.points, "point"),
                      EstimateText(report.options), report.server);
  if (report.summary.normals.has_value()) absl::StrAppend(&text, "  ", NormalsText(*report.summary.normals), "\n");
  if (report.summary.scale.has_value()) absl::StrAppend(&text, ScaleText(*report.summary.scale));
  AppendResults(report, result, text);
  absl::StrAppend(&text, "  seconds:");
  for (const auto& [phase, seconds] : PhaseSeconds(report)) absl::StrAppendFormat(&text, " %s %.3f", phase, seconds);
  absl::StrAppend(&text, "\n");
  if (report.summary.normals_rescaled > 0) {
    absl::StrAppend(&text, "  ", WithCommas(report.summary.normals_rescaled),
                    " normals were not of unit length and were normalized\n");
  }
  if (report.summary.attempts > 1) absl::StrAppend(&text, "  sent ", report.summary.attempts, " times\n");
  return absl::StrCat(text, "  wrote ", ShownOutput(report.output), "\n");
}

std::string SummaryJson(const EstimateReport& report, const PointTable& result) {
  nlohmann::ordered_json seconds;
  for (const auto& [phase, value] : PhaseSeconds(report)) seconds[phase] = value;
  nlohmann::ordered_json json = {{"input", report.input},
                                 {"output", report.output},
                                 {"server", report.server},
                                 {"request_id", report.summary.request_id},
                                 {"attempts", report.summary.attempts},
                                 {"estimator", EstimatorName(report.options.estimator)}};
  if (!report.options.neighbor_counts.empty()) {
    json["neighbor_counts"] = report.options.neighbor_counts;
  } else if (report.options.automatic_scale) {
    json["neighbor_count"] = "auto";
  } else if (report.options.radius) {
    json["radius"] = *report.options.radius;
  } else {
    json["neighbor_count"] = report.options.neighbor_count;
  }
  json["triangle_count"] = report.options.triangle_count;
  json["seed"] = report.options.seed;
  json["rotation_count"] = report.options.rotation_count;
  json["jet_degree"] = JetDegree(report.options);
  json["regression_degree"] = report.options.regression_degree;
  json["even_weights"] = report.options.even_weights;
  json["project"] = report.options.project;
  json["points"] = report.summary.points;
  json["status"] = StatusJson(report.summary.status_counts);
  json["ranges"] = RangesJson(result, "");
  if (!report.options.neighbor_counts.empty()) json["scales"] = ScalesJson(report, result);
  json["seconds"] = std::move(seconds);
  json["normals_rescaled"] = report.summary.normals_rescaled;
  json["server_peak_bytes"] = report.summary.peak_bytes;
  if (report.summary.normals.has_value()) json["normals"] = NormalsJson(*report.summary.normals);
  if (report.summary.scale.has_value()) json["scale"] = ScaleJson(*report.summary.scale);
  json["warnings"] = WarningsJson(report.summary);
  return ToJsonLine(json);
}

}  // namespace curv
