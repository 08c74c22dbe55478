#include "client/cli/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client/cli/result_columns.h"
#include "client/io/point_status.h"
#include "client/surfaces/vec3.h"

namespace curv {
namespace {

using Axes = std::array<const Column*, 3>;

bool IsOk(const Column* status, size_t i) {
  return status == nullptr || status->At(i) == static_cast<double>(PointStatus::kOk);
}

// Errors are summed in the order of the points.
QuantityError Compare(const std::string& word, const Column& estimate, const Column& truth, const Column* status,
                      size_t& compared) {
  double sum = 0.0, squares = 0.0, largest = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < estimate.size(); ++i) {
    const double error = std::abs(estimate.At(i) - truth.At(i));
    if (!IsOk(status, i) || !std::isfinite(error)) continue;
    sum += error;
    squares += error * error;
    largest = std::max(largest, error);
    ++count;
  }
  compared = count;
  const double n = static_cast<double>(count);
  return {word, sum / n, std::sqrt(squares / n), count == 0 ? sum / n : largest};
}

bool FindVector(const PointTable& table, const std::string& name, const std::string& suffix, Axes& axes) {
  for (size_t axis = 0; axis < 3; ++axis) {
    axes[axis] = table.Find(absl::StrCat(name, std::string(1, "xyz"[axis]), suffix));
    if (axes[axis] == nullptr) return false;
  }
  return true;
}

Vec3 At(const Axes& axes, size_t i) { return {axes[0]->At(i), axes[1]->At(i), axes[2]->At(i)}; }

// Every direction is principal where the curvatures are equal, but for the rounding to float.
bool HasDirections(const Column* k1, const Column* k2, size_t i) {
  if (k1 == nullptr || k2 == nullptr) return true;
  const double a = k1->At(i), b = k2->At(i);
  return std::abs(a - b) > 1e-6 * std::max(std::abs(a), std::abs(b));
}

std::optional<double> MedianAngle(const PointTable& table, const std::string& name, const std::string& suffix) {
  Axes estimate, truth;
  if (!FindVector(table, name, suffix, estimate) || !FindVector(table, "true_" + name, "", truth)) return std::nullopt;
  const Column* const status = table.Find("status" + suffix);
  const Column* const k1 = table.Find("true_k1");
  const Column* const k2 = table.Find("true_k2");
  std::vector<double> angles;
  for (size_t i = 0; i < table.size(); ++i) {
    if (!IsOk(status, i) || !HasDirections(k1, k2, i)) continue;
    const Vec3 a = At(estimate, i), b = At(truth, i);
    const double angle = std::atan2(Norm(Cross(a, b)), std::abs(Dot(a, b)));
    if (std::isfinite(angle)) angles.push_back(angle);
  }
  if (angles.empty()) return std::nullopt;
  const auto middle = angles.begin() + static_cast<ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle * 180.0 / std::numbers::pi;
}

}  // namespace

absl::StatusOr<Accuracy> MeasureAccuracy(const PointTable& table, const std::string& suffix) {
  Accuracy accuracy{.points = table.size()};
  for (const NamedQuantity& quantity : kQuantities) {
    const Column* const estimate = table.Find(quantity.column + suffix);
    const Column* const truth = table.Find(quantity.truth_column);
    if (estimate == nullptr || truth == nullptr) continue;
    size_t compared = 0;
    accuracy.errors.push_back(Compare(quantity.word, *estimate, *truth, table.Find("status" + suffix), compared));
    accuracy.compared = std::max(accuracy.compared, compared);
  }
  if (accuracy.errors.empty()) {
    const bool has_truth = table.Find("true_mean") != nullptr;
    return absl::InvalidArgumentError(
        has_truth
            ? "there are no estimates: the columns mean_curvature, gaussian_curvature, k1 and k2 are missing. Run "
              "curv estimate on the file first"
            : "there is no truth to compare with: the columns true_mean, true_gaussian, true_k1 and true_k2 are "
              "missing. curv generate writes them, and curv estimate carries them through");
  }
  accuracy.d1_angle = MedianAngle(table, "d1", suffix);
  accuracy.d2_angle = MedianAngle(table, "d2", suffix);
  return accuracy;
}

std::vector<std::string> EstimateSuffixes(const PointTable& table) {
  std::vector<std::string> suffixes;
  for (const Column& column : table.columns()) {
    const std::string name = WithoutScale(column.name);
    if (QuantityOfColumn(name) == nullptr) continue;
    const std::string suffix = column.name.substr(name.size());
    uint32_t neighbor_count = 0;
    if (!suffix.empty() && !absl::SimpleAtoi(suffix.substr(sizeof("_k") - 1), &neighbor_count)) continue;
    if (std::find(suffixes.begin(), suffixes.end(), suffix) == suffixes.end()) suffixes.push_back(suffix);
  }
  return suffixes;
}

}  // namespace curv
