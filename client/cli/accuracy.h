// Measures how far estimates are from the exact values that a file carries.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

struct QuantityError {
  std::string quantity;  // "mean", "gaussian", "k1", "k2"
  double mean;           // of the absolute errors
  double rms;
  double largest;
};

struct Accuracy {
  size_t points = 0;    // in the file
  size_t compared = 0;  // of these, with status ok and finite values
  std::vector<QuantityError> errors{};
  // Median angles in degrees between a principal direction and the true one. Signs are ignored, and so are points whose
  // true principal curvatures are equal. There is none if the file has no true directions or no such point.
  std::optional<double> d1_angle{};
  std::optional<double> d2_angle{};
};

// Compares mean_curvature with true_mean and so on, for the quantities whose columns are both there. `suffix` is what
// the names of estimates end in (ScaleSuffix), if they are those at one of several numbers of neighbors.
// INVALID_ARGUMENT if there is no such pair; the message says which columns are missing.
absl::StatusOr<Accuracy> MeasureAccuracy(const PointTable& table, const std::string& suffix = "");

// The suffixes of the table's estimates of curvature, in the order of its columns: "" where they have none.
// A number of neighbors that has no room in 32 bits makes no suffix.
std::vector<std::string> EstimateSuffixes(const PointTable& table);

}  // namespace curv
