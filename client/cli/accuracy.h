// How far estimates are from the truth that a file carries.
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
  size_t points = 0;    // all
  size_t compared = 0;  // with status ok and finite values
  std::vector<QuantityError> errors{};
  // Median angles in degrees between a direction and the true one, signs ignored; over points whose true principal
  // curvatures differ. None if the file has no true directions or no such point.
  std::optional<double> d1_angle{};
  std::optional<double> d2_angle{};
};

// Compares mean_curvature with true_mean and so on, for the quantities whose columns are both there.
// INVALID_ARGUMENT if there is no such pair; the message says which columns are missing.
absl::StatusOr<Accuracy> MeasureAccuracy(const PointTable& table);

}  // namespace curv
