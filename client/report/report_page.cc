#include "client/report/report_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/io/point_status.h"
#include "client/render/pose.h"
#include "client/report/page_parts.h"
#include "client/report/payload.h"
#include "client/report/quantize.h"
#include "client/report/report_points.h"
#include "client/report/report_quantity.h"
#include "client/report/thinning.h"

namespace curv {
namespace {

using Json = nlohmann::ordered_json;

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

Json QuantitiesJson(const std::vector<ReportQuantity>& quantities) {
  Json json = Json::array();
  for (const ReportQuantity& quantity : quantities) json.push_back(QuantityJson(quantity, ScaleOf(quantity)));
  return json;
}

// Adds the values from `begin` to `end` of the chosen points.
void AppendQuantities(const std::vector<ReportQuantity>& quantities, size_t begin, size_t end, Payload& payload) {
  for (size_t q = 0; q < quantities.size(); ++q) {
    const double scale = ScaleOf(quantities[q]);
    std::vector<uint16_t> codes;
    codes.reserve(end - begin);
    for (size_t i = begin; i < end; ++i) codes.push_back(HalfBits(quantities[q].values[i] / scale));
    payload.Add("quantity" + std::to_string(q), codes);
  }
}

void AppendStatuses(const std::vector<uint8_t>& statuses, const std::vector<uint32_t>& chosen, Payload& payload) {
  if (statuses.empty()) return;
  std::vector<uint8_t> of_chosen;
  of_chosen.reserve(chosen.size());
  for (const uint32_t i : chosen) of_chosen.push_back(statuses[i]);
  payload.Add("status", of_chosen);
}

void AppendIndices(const std::vector<uint32_t>& chosen, Payload& payload) {
  std::vector<uint16_t> low, high;
  for (const uint32_t i : chosen) {
    low.push_back(static_cast<uint16_t>(i & 0xffff));
    high.push_back(static_cast<uint16_t>(i >> 16));
  }
  payload.Add("index_low", low);
  payload.Add("index_high", high);
}

Json ArraysJson(const Payload& payload) {
  Json json = Json::array();
  for (const PackedArray& array : payload.arrays()) {
    json.push_back({{"name", array.name}, {"count", array.count}, {"bytes", array.bytes_per_scalar}});
  }
  return json;
}

// What a report shows of a table, and what the page needs to know of it.
struct Selection {
  Bounds bounds;
  Thinning thinning;
  std::vector<uint8_t> statuses;
  ReportQuantities quantities;
};

absl::StatusOr<Selection> Select(const PointTable& table, const ReportOptions& options, bool is_shuffled) {
  Selection selection{.bounds = BoundsOf(table), .thinning = {}, .statuses = StatusesOf(table), .quantities = {}};
  if (selection.bounds.finite == 0) {
    return absl::InvalidArgumentError("there is no point with a finite position to show");
  }
  selection.thinning = ChoosePoints(table.size(), options.most_points);
  std::vector<uint32_t>& chosen = selection.thinning.chosen;
  if (is_shuffled) {
    std::sort(chosen.begin(), chosen.end(), [](uint32_t a, uint32_t b) { return IndexHash(a) < IndexHash(b); });
  }
  selection.quantities =
      ChooseQuantities(table, chosen,
                       {.most = std::clamp(kMostValues / chosen.size(), kFewestQuantities, kMostQuantities),
                        .wanted = options.quantity});
  return selection;
}

Json ReportJson(const PointTable& table, const ReportOptions& options, const Selection& selection, bool is_shuffled) {
  // In shuffled order the first stand for all.
  constexpr ptrdiff_t kPosePoints = 1'000'000;
  const std::vector<uint32_t>& chosen = selection.thinning.chosen;
  const auto end = chosen.begin() + std::min(kPosePoints, std::ssize(chosen));
  const Pose pose = PoseOf(table, is_shuffled ? std::vector(chosen.begin(), end) : chosen, options.up_axis);
  return {{"title", options.title},
          {"unit", options.unit},
          {"up", std::string(1, pose.up_axis)},
          {"pose", {pose.azimuth, pose.elevation}},
          {"quantity", options.quantity},
          {"points", table.size()},
          {"shown", chosen.size()},
          {"hashLimit", selection.thinning.limit},
          {"unplaced", table.size() - selection.bounds.finite},
          {"low", selection.bounds.low},
          {"high", selection.bounds.high},
          {"statuses", StatusesJson(selection.statuses)},
          {"percents", kReportPercents},
          {"quantities", QuantitiesJson(selection.quantities.shown)},
          {"leftOut", selection.quantities.left_out},
          {"notes", table.notes}};
}

// How many points the blocks have: all, or first some, so that there is something to see, then the rest in large ones.
std::vector<size_t> BlockSizes(size_t points) {
  constexpr size_t kFirstPoints = 200'000, kBlockPoints = 1'000'000;
  if (points <= kBlockPoints) return {points};
  std::vector<size_t> sizes = {kFirstPoints};
  for (size_t left = points - kFirstPoints; left > 0; left -= sizes.back()) {
    sizes.push_back(std::min(left, kBlockPoints));
  }
  return sizes;
}

}  // namespace

absl::StatusOr<std::string> MakeReportPage(const PointTable& table, const ReportOptions& options) {
  const absl::StatusOr<Selection> selection = Select(table, options, /*is_shuffled=*/false);
  if (!selection.ok()) return selection.status();
  const std::vector<uint32_t>& chosen = selection->thinning.chosen;
  Payload payload;
  const EncodedPoints encoded = AppendPoints(table, chosen, selection->bounds, selection->statuses, payload);
  AppendStatuses(selection->statuses, chosen, payload);
  AppendQuantities(selection->quantities.shown, 0, chosen.size(), payload);
  Json json = ReportJson(table, options, *selection, /*is_shuffled=*/false);
  json["largestRadius"] = encoded.largest_radius;
  json["arrays"] = ArraysJson(payload);
  const absl::StatusOr<std::string> points = payload.Encode();
  if (!points.ok()) return points.status();
  return FillPage({.report = ScriptJson(json), .points = *points});
}

std::string MakeViewPage(bool reads_laz) {
  return FillPage({.may_ask = true, .has_codec = reads_laz, .report = ScriptJson({{"served", true}})});
}

absl::Status ServeReport(const PointTable& table, const ReportOptions& options, uint64_t generation, bool watches,
                         const std::stop_token& stop, ReportShelf& shelf) {
  const absl::StatusOr<Selection> selection = Select(table, options, /*is_shuffled=*/true);
  if (!selection.ok()) return selection.status();
  const std::vector<uint32_t>& chosen = selection->thinning.chosen;
  const std::vector<size_t> sizes = BlockSizes(chosen.size());
  std::shared_ptr<GrowingBytes> bytes;
  SplatSizes splats;
  size_t begin = 0;
  for (const size_t size : sizes) {
    const std::vector<uint32_t> block(chosen.begin() + static_cast<ptrdiff_t>(begin),
                                      chosen.begin() + static_cast<ptrdiff_t>(begin + size));
    splats.share = static_cast<double>(size) / static_cast<double>(chosen.size());
    Payload payload;
    const EncodedPoints encoded = AppendPoints(table, block, selection->bounds, selection->statuses, payload, splats);
    AppendStatuses(selection->statuses, block, payload);
    AppendQuantities(selection->quantities.shown, begin, begin + size, payload);
    AppendIndices(block, payload);
    begin += size;
    const Json arrays = ArraysJson(payload);
    std::string encoded_bytes = payload.TakeBytes();
    if (bytes == nullptr) {
      splats.largest = encoded.largest_radius;
      Json json = ReportJson(table, options, *selection, /*is_shuffled=*/true);
      json["largestRadius"] = splats.largest;
      json["arrays"] = arrays;
      json["blocks"] = sizes;
      json["generation"] = generation;
      json["watches"] = watches;
      bytes = std::make_shared<GrowingBytes>(encoded_bytes.size() / size * chosen.size());
      shelf.Put({.generation = generation, .report = ScriptJson(json), .points = bytes});
    }
    bytes->Append(std::move(encoded_bytes));
    if (stop.stop_requested()) break;
  }
  return absl::OkStatus();
}

void ServeWaiting(const std::string& name, ReportShelf& shelf) {
  shelf.Put({.generation = 0,
             .report = ScriptJson({{"waiting", name}, {"generation", 0}, {"watches", true}}),
             .points = std::make_shared<GrowingBytes>(0)});
}

}  // namespace curv
