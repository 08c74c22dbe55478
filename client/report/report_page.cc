#include "client/report/report_page.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_replace.h"
#include "client/io/point_status.h"
#include "client/render/pose.h"
#include "client/report/page_template.h"
#include "client/report/payload.h"
#include "client/report/quantize.h"
#include "client/report/report_points.h"
#include "client/report/report_quantity.h"
#include "client/report/thinning.h"

namespace curv {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kReportPlace = "@curv-report@";
constexpr std::string_view kPointsPlace = "@curv-points@";

// One for each status that points of the file have.
Json StatusesJson(const std::vector<uint8_t>& statuses) {
  std::vector<uint64_t> counts(256);
  for (const uint8_t status : statuses) ++counts[status];
  Json json = Json::array();
  for (size_t value = 0; value < counts.size(); ++value) {
    if (counts[value] == 0) continue;
    json.push_back(
        {{"value", value}, {"word", std::string(StatusWord(static_cast<uint8_t>(value)))}, {"count", counts[value]}});
  }
  return json;
}

// The number that binary16 codes of a quantity are multiplied with, so that the largest value is the largest code.
double ScaleOf(const ReportQuantity& quantity) {
  double largest = 0.0;
  for (const double value : quantity.values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  const double scale = largest / kLargestHalf;
  return std::isnormal(scale) ? scale : 1.0;
}

Json QuantityJson(const ReportQuantity& quantity, double scale) {
  Json json = {{"column", quantity.column},
               {"title", quantity.title},
               {"signed", quantity.is_signed},
               {"finite", quantity.finite},
               {"scale", scale},
               {"low", quantity.low},
               {"high", quantity.high},
               {"percentiles", quantity.percentiles}};
  if (quantity.has_unit) json["exponent"] = quantity.length_exponent;
  return json;
}

Json AppendQuantities(const std::vector<ReportQuantity>& quantities, Payload& payload) {
  Json json = Json::array();
  for (size_t q = 0; q < quantities.size(); ++q) {
    const double scale = ScaleOf(quantities[q]);
    std::vector<uint16_t> codes;
    codes.reserve(quantities[q].values.size());
    for (const double value : quantities[q].values) codes.push_back(HalfBits(value / scale));
    payload.Add("quantity" + std::to_string(q), codes);
    json.push_back(QuantityJson(quantities[q], scale));
  }
  return json;
}

void AppendStatuses(const std::vector<uint8_t>& statuses, const std::vector<uint32_t>& chosen, Payload& payload) {
  if (statuses.empty()) return;
  std::vector<uint8_t> of_chosen;
  of_chosen.reserve(chosen.size());
  for (const uint32_t i : chosen) of_chosen.push_back(statuses[i]);
  payload.Add("status", of_chosen);
}

Json ArraysJson(const Payload& payload) {
  Json json = Json::array();
  for (const PackedArray& array : payload.arrays()) {
    json.push_back({{"name", array.name}, {"count", array.count}, {"bytes", array.bytes_per_scalar}});
  }
  return json;
}

// JSON in a script element: it ends at the first `</script`, so no `<` may stand there.
std::string ScriptJson(const Json& json) {
  return absl::StrReplaceAll(json.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace),
                             {{"<", "\\u003c"}});
}

std::string FillIn(std::string_view report, std::string_view points) {
  const std::string_view page = PageTemplate();
  const size_t report_at = page.find(kReportPlace), points_at = page.find(kPointsPlace);
  std::string filled;
  filled.reserve(page.size() + report.size() + points.size());
  filled.append(page.substr(0, report_at)).append(report);
  filled.append(page.substr(report_at + kReportPlace.size(), points_at - report_at - kReportPlace.size()));
  filled.append(points).append(page.substr(points_at + kPointsPlace.size()));
  return filled;
}

}  // namespace

absl::StatusOr<std::string> MakeReportPage(const PointTable& table, const ReportOptions& options) {
  const Bounds bounds = BoundsOf(table);
  if (bounds.finite == 0) return absl::InvalidArgumentError("there is no point with a finite position to show");
  const Thinning thinning = ChoosePoints(table.size(), options.most_points);
  const std::vector<uint8_t> statuses = StatusesOf(table);
  Payload payload;
  const EncodedPoints encoded = AppendPoints(table, thinning.chosen, bounds, statuses, payload);
  AppendStatuses(statuses, thinning.chosen, payload);
  const ReportQuantities quantities =
      ChooseQuantities(table, thinning.chosen,
                       {.most = std::clamp(kMostValues / thinning.chosen.size(), kFewestQuantities, kMostQuantities),
                        .wanted = options.quantity});
  const Pose pose = PoseOf(table, thinning.chosen, options.up_axis);
  Json json = {{"title", options.title},
               {"unit", options.unit},
               {"up", std::string(1, pose.up_axis)},
               {"pose", {pose.azimuth, pose.elevation}},
               {"quantity", options.quantity},
               {"points", table.size()},
               {"shown", thinning.chosen.size()},
               {"hashLimit", thinning.limit},
               {"unplaced", table.size() - bounds.finite},
               {"low", bounds.low},
               {"high", bounds.high},
               {"largestRadius", encoded.largest_radius},
               {"statuses", StatusesJson(statuses)},
               {"percents", kReportPercents},
               {"quantities", AppendQuantities(quantities.shown, payload)},
               {"leftOut", quantities.left_out},
               {"notes", table.notes}};
  json["arrays"] = ArraysJson(payload);
  const absl::StatusOr<std::string> points = payload.Encode();
  if (!points.ok()) return points.status();
  return FillIn(ScriptJson(json), *points);
}

}  // namespace curv
