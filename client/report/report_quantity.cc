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

constexpr KnownColumn kKnownColumns[] = {
    {"mean_curvature", "Mean curvature H", -1, true, true},
    {"gaussian_curvature", "Gaussian curvature G", -2, true, true},
    {"k1", "Principal curvature k\u2081", -1, true, true},
    {"k2", "Principal curvature k\u2082", -1, true, true},
    {"shape_index", "Shape index", 0, true, true},
    {"curvedness", "Curvedness", -1, true, false},
    {"normal_curvature", "Normal curvature", -1, true, true},
    {"mean_curvature_standard_error", "Standard error of H", -1, true, false},
    {"k1_standard_error", "Standard error of k\u2081", -1, true, false},
    {"k2_standard_error", "Standard error of k\u2082", -1, true, false},
    {"chosen_neighbor_count", "Chosen neighbor count", 0, true, false},
    {"radius", "Radius of the neighborhood", 1, false, false},
    {"normal_residual", "Residual of the normal's fit", 1, false, false},
    {"normal_variance_ratio", "Variance ratio of the normal's fit", 0, false, false},
    {"true_mean", "Mean curvature H (exact)", -1, false, true},
    {"true_gaussian", "Gaussian curvature G (exact)", -2, false, true},
    {"true_k1", "Principal curvature k\u2081 (exact)", -1, false, true},
    {"true_k2", "Principal curvature k\u2082 (exact)", -1, false, true},
};

bool IsNoQuantity(const std::string& name) {
  static const auto* const names = [] {
    const std::vector<std::string> all = NamesOfNoQuantity();
    return new std::set<std::string>(all.begin(), all.end());
  }();
  return names->contains(name);
}

std::vector<double> ValuesOfColumn(const Column& column) {
  return std::visit([](const auto& values) { return std::vector<double>(values.begin(), values.end()); },
                    column.values);
}

// Keeps low < high where all values are the same, or nearly.
void Widen(double& low, double& high) {
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low > 1e-6 * size) return;
  const double by = size > 0.0 ? 0.5 * size : 1.0;
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

// A column that can be shown; known is nullptr for one of the file's own.
struct Candidate {
  const KnownColumn* known;
  const Column* column;
};

std::vector<Candidate> FindCandidates(const PointTable& table) {
  std::vector<Candidate> candidates;
  std::set<std::string> known_names;
  for (const KnownColumn& known : kKnownColumns) {
    known_names.insert(known.column);
    if (const Column* const column = table.Find(known.column)) candidates.push_back({&known, column});
  }
  for (const Column& column : table.columns()) {
    if (!IsNoQuantity(column.name) && !known_names.contains(column.name)) candidates.push_back({nullptr, &column});
  }
  return candidates;
}

}  // namespace

std::span<const KnownColumn> KnownColumns() { return kKnownColumns; }

std::vector<std::string> NamesOfNoQuantity() {
  std::vector<std::string> names = {"red", "green", "blue", "alpha", "status"};
  for (const char* prefix : {"", "n", "d1", "d2", "true_n", "true_d1", "true_d2"}) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string(prefix) + axis);
  }
  return names;
}

ReportQuantities ChooseQuantities(const PointTable& table, const std::vector<uint32_t>& chosen,
                                  const QuantityLimits& limits) {
  std::vector<Candidate> candidates = FindCandidates(table);
  const auto wanted = std::find_if(candidates.begin(), candidates.end(),
                                   [&](const Candidate& c) { return c.column->name == limits.wanted; });
  const auto most = static_cast<ptrdiff_t>(std::min(limits.most, candidates.size()));
  if (wanted != candidates.end() && wanted - candidates.begin() >= most) {
    std::rotate(candidates.begin() + most - 1, wanted, wanted + 1);
  }
  const std::vector<uint8_t> statuses = StatusesOf(table);
  ReportQuantities quantities;
  for (const Candidate& candidate : candidates) {
    if (quantities.shown.size() == limits.most) {
      quantities.left_out.push_back(candidate.column->name);
    } else if (candidate.known != nullptr) {
      quantities.shown.push_back(KnownQuantity(*candidate.known, *candidate.column, statuses, chosen));
    } else {
      quantities.shown.push_back(OtherQuantity(*candidate.column, chosen));
    }
  }
  return quantities;
}

bool IsShownInReports(const PointTable& table, const std::string& column) {
  if (column == "status") return !StatusesOf(table).empty();
  return table.Find(column) != nullptr && !IsNoQuantity(column);
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
