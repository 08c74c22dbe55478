#include "client/report/report_quantity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "client/io/point_status.h"
#include "client/render/color_scale.h"

namespace curv {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// What the report knows of a column before it looks at its values.
struct KnownColumn {
  const char* column;
  const char* title;
  int length_exponent;
  bool is_curvature;  // it exists only where the status is ok
  bool is_signed;
};
constexpr KnownColumn kKnownColumns[] = {
    {"mean_curvature", "Mean curvature H", -1, true, true},
    {"gaussian_curvature", "Gaussian curvature G", -2, true, true},
    {"k1", "Principal curvature k\u2081", -1, true, true},
    {"k2", "Principal curvature k\u2082", -1, true, true},
    {"shape_index", "Shape index", 0, true, true},
    {"curvedness", "Curvedness", -1, true, false},
    {"radius", "Radius of the neighborhood", 1, false, false},
    {"normal_residual", "Residual of the normal's fit", 1, false, false},
    {"normal_variance_ratio", "Variance ratio of the normal's fit", 0, false, false},
    {"true_mean", "Mean curvature H (exact)", -1, false, true},
    {"true_gaussian", "Gaussian curvature G (exact)", -2, false, true},
    {"true_k1", "Principal curvature k\u2081 (exact)", -1, false, true},
    {"true_k2", "Principal curvature k\u2082 (exact)", -1, false, true},
};

bool IsNoQuantity(const std::string& name) {
  static const auto* const names =
      new std::set<std::string>{"x",   "y",   "z",   "nx",  "ny",    "nz",   "d1x",   "d1y",   "d1z",
                                "d2x", "d2y", "d2z", "red", "green", "blue", "alpha", "status"};
  return names->contains(name);
}

std::vector<double> ValuesOfColumn(const Column& column) {
  return std::visit([](const auto& values) { return std::vector<double>(values.begin(), values.end()); },
                    column.values);
}

// Keeps low < high where all values are the same, or nearly.
void Widen(double& low, double& high) {
  const double least = std::max({std::abs(low), std::abs(high)}) * 1e-6;
  if (high - low > least) return;
  const double by = least > 0.0 ? least : 1.0;
  low -= by;
  high += by;
}

// Reads percentiles and ends of the colors off the finite values of all points; keeps those of the chosen ones.
void SumUp(std::vector<double> values, const std::vector<uint32_t>& chosen, ReportQuantity& quantity) {
  quantity.values.reserve(chosen.size());
  for (const uint32_t i : chosen) quantity.values.push_back(values[i]);
  std::vector<double> sorted = std::move(values);
  std::erase_if(sorted, [](double value) { return !std::isfinite(value); });
  std::sort(sorted.begin(), sorted.end());
  quantity.finite = sorted.size();
  quantity.percentiles.fill(kNaN);
  if (sorted.empty()) return;
  for (size_t i = 0; i < kReportPercents.size(); ++i) {
    const double rank = kReportPercents[i] / 100.0 * static_cast<double>(sorted.size() - 1);
    quantity.percentiles[i] = sorted[static_cast<size_t>(std::lround(rank))];
  }
  if (quantity.is_signed) {
    const ColorScale scale = ColorScale::ForValues(sorted);
    quantity.low = scale.low();
    quantity.high = scale.high();
    return;
  }
  constexpr double kLargestEnd = 0.25 * std::numeric_limits<double>::max();
  quantity.low = std::clamp(quantity.percentiles[1], -kLargestEnd, kLargestEnd);
  quantity.high = std::clamp(quantity.percentiles[7], -kLargestEnd, kLargestEnd);
  Widen(quantity.low, quantity.high);
}

ReportQuantity KnownQuantity(const KnownColumn& known, const Column& column, const std::vector<uint8_t>& statuses,
                             const std::vector<uint32_t>& chosen) {
  ReportQuantity quantity{.column = known.column,
                          .title = known.title,
                          .length_exponent = known.length_exponent,
                          .has_unit = true,
                          .is_signed = known.is_signed};
  std::vector<double> values = ValuesOfColumn(column);
  for (size_t i = 0; known.is_curvature && i < statuses.size(); ++i) {
    if (statuses[i] != static_cast<uint8_t>(PointStatus::kOk)) values[i] = kNaN;
  }
  SumUp(std::move(values), chosen, quantity);
  return quantity;
}

ReportQuantity OtherQuantity(const Column& column, const std::vector<uint32_t>& chosen) {
  ReportQuantity quantity{.column = column.name, .title = column.name};
  std::vector<double> values = ValuesOfColumn(column);
  const auto is_below = [](double value) { return value < 0.0 && std::isfinite(value); };
  const auto is_above = [](double value) { return value > 0.0 && std::isfinite(value); };
  quantity.is_signed =
      std::any_of(values.begin(), values.end(), is_below) && std::any_of(values.begin(), values.end(), is_above);
  SumUp(std::move(values), chosen, quantity);
  return quantity;
}

}  // namespace

ReportQuantities ChooseQuantities(const PointTable& table, const std::vector<uint32_t>& chosen, size_t most) {
  const std::vector<uint8_t> statuses = StatusesOf(table);
  ReportQuantities quantities;
  std::set<std::string> known_names;
  const auto has_room = [&](const std::string& name) {
    if (quantities.shown.size() < most) return true;
    quantities.left_out.push_back(name);
    return false;
  };
  for (const KnownColumn& known : kKnownColumns) {
    known_names.insert(known.column);
    const Column* const column = table.Find(known.column);
    if (column == nullptr || !has_room(known.column)) continue;
    quantities.shown.push_back(KnownQuantity(known, *column, statuses, chosen));
  }
  for (const Column& column : table.columns()) {
    if (IsNoQuantity(column.name) || known_names.contains(column.name) || !has_room(column.name)) continue;
    quantities.shown.push_back(OtherQuantity(column, chosen));
  }
  return quantities;
}

std::vector<uint8_t> StatusesOf(const PointTable& table) {
  const Column* const column = table.Find("status");
  if (column == nullptr) return {};
  std::vector<uint8_t> statuses(column->size());
  for (size_t i = 0; i < statuses.size(); ++i) {
    const double value = column->At(i);
    if (!(value >= 0.0 && value <= 255.0) || value != std::floor(value)) return {};
    statuses[i] = static_cast<uint8_t>(value);
  }
  return statuses;
}

}  // namespace curv
