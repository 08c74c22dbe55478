#include "client/cli/estimate_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"

namespace curv {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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
  return {
      {"read", report.read_seconds},    {"receive", s.receive_seconds},
      {"queue", s.queue_seconds},       {"index", s.index_seconds},
      {"estimate", s.estimate_seconds}, {"send", s.send_seconds},
      {"write", report.write_seconds},  {"total", report.read_seconds + report.call_seconds + report.write_seconds}};
}

std::string NeighborhoodText(const EstimateOptions& options) {
  return options.radius ? absl::StrFormat("radius %g", *options.radius)
                        : absl::StrFormat("K = %d", static_cast<int>(options.neighbor_count));
}

}  // namespace

std::string SummaryText(const EstimateReport& report, const PointTable& result) {
  std::string text = absl::StrFormat(
      "%s: %s points, %s, %s, server %s\n", report.input, WithCommas(report.summary.points),
      std::string(EstimatorName(report.options.estimator)), NeighborhoodText(report.options), report.server);
  for (size_t status = 1; status < kStatusWords.size(); ++status) {
    const uint64_t count = report.summary.status_counts[status];
    if (status > 1 && count == 0) continue;
    absl::StrAppendFormat(&text, "  %-22s %14s\n", std::string(kStatusWords[status]), WithCommas(count));
  }
  absl::StrAppendFormat(&text, "  %-22s %14s %14s %14s\n", "", "least", "median", "largest");
  for (const NamedQuantity& quantity : kQuantities) {
    if (result.Find(quantity.column) == nullptr) continue;
    const Spread spread = SpreadOf(result, quantity.column);
    absl::StrAppendFormat(&text, "  %-22s %14.6g %14.6g %14.6g\n", quantity.column, spread.low, spread.median,
                          spread.high);
  }
  absl::StrAppend(&text, "  seconds:");
  for (const auto& [phase, seconds] : PhaseSeconds(report)) absl::StrAppendFormat(&text, " %s %.3f", phase, seconds);
  absl::StrAppend(&text, "\n");
  if (report.summary.normals_rescaled > 0) {
    absl::StrAppend(&text, "  ", WithCommas(report.summary.normals_rescaled),
                    " normals were not of unit length and were normalized\n");
  }
  if (report.summary.attempts > 1) absl::StrAppend(&text, "  sent ", report.summary.attempts, " times\n");
  return absl::StrCat(text, "  wrote ", report.output, "\n");
}

std::string SummaryJson(const EstimateReport& report, const PointTable& result) {
  JsonObject statuses, ranges, seconds, json;
  for (size_t status = 1; status < kStatusWords.size(); ++status) {
    statuses.Add(kStatusWords[status], report.summary.status_counts[status]);
  }
  for (const NamedQuantity& quantity : kQuantities) {
    if (result.Find(quantity.column) == nullptr) continue;
    const Spread spread = SpreadOf(result, quantity.column);
    ranges.Add(quantity.column,
               JsonObject().Add("least", spread.low).Add("median", spread.median).Add("largest", spread.high));
  }
  for (const auto& [phase, value] : PhaseSeconds(report)) seconds.Add(phase, value);
  json.Add("input", report.input).Add("output", report.output).Add("server", report.server);
  json.Add("request_id", report.summary.request_id).Add("attempts", static_cast<uint64_t>(report.summary.attempts));
  json.Add("estimator", EstimatorName(report.options.estimator));
  if (report.options.radius) {
    json.Add("radius", *report.options.radius);
  } else {
    json.Add("neighbor_count", uint64_t{report.options.neighbor_count});
  }
  json.Add("triangle_count", uint64_t{report.options.triangle_count}).Add("seed", report.options.seed);
  json.Add("rotation_count", uint64_t{report.options.rotation_count});
  json.Add("jet_degree", uint64_t{report.options.jet_degree}).Add("even_weights", report.options.even_weights);
  json.Add("points", report.summary.points).Add("status", statuses).Add("ranges", ranges).Add("seconds", seconds);
  json.Add("normals_rescaled", report.summary.normals_rescaled).Add("server_peak_bytes", report.summary.peak_bytes);
  return json.ToString() + "\n";
}

}  // namespace curv
