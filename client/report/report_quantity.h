// Chooses the columns of a result that a report shows, and sums each up.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "client/io/point_table.h"

namespace curv {

// Per cent of the values below which each entry of ReportQuantity::percentiles lies.
inline constexpr std::array<double, 9> kReportPercents = {0.0, 1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0, 100.0};

// What a report knows of a column before it looks at its values.
struct KnownColumn {
  const char* column;
  const char* title;
  int length_exponent;
  bool is_curvature;  // it exists only where the status is ok
  bool is_signed;
};

// Returns the columns that reports know, those that are shown first at the front.
std::span<const KnownColumn> KnownColumns();

// Returns the names of columns that are parts of vectors, colors, or no quantities.
std::vector<std::string> NamesOfNoQuantity();

// A quantity as a report shows it. Numbers count all points of the file, whether the report holds them or not.
struct ReportQuantity {
  std::string column;            // "mean_curvature"
  std::string title;             // "Mean curvature H"; the column's name if the report knows no other
  int length_exponent = 0;       // of the unit: -1 for 1/length; 0 for none or an unknown one, see has_unit
  bool has_unit = false;         // whether the exponent is known
  bool is_signed = false;        // colors are symmetric about zero
  std::vector<double> values{};  // of each chosen point; NaN where there is none
  size_t finite = 0;             // how many values are finite
  std::array<double, kReportPercents.size()> percentiles{};  // of the finite values, by nearest rank; NaN if none is
  // Ends of the colors: symmetric and wide enough for 98 % of the values if signed, else from 1 % to 99 %. Always
  // low < high, finite, with a finite difference.
  double low = -1.0;
  double high = 1.0;
};

struct QuantityLimits {
  size_t most;           // quantities that are shown, at least 1
  std::string wanted{};  // a column that is shown even if others come before it; DEFAULT: none
};

struct ReportQuantities {
  std::vector<ReportQuantity> shown;
  std::vector<std::string> left_out;  // names of the columns beyond the limit
};

// Returns the quantities of a table: curvatures first, then other results, then the file's own columns in order; not
// positions, normals, directions, colors and status. Where a status is not `ok`, curvatures have no value, whatever the
// file says. REQUIRES: `chosen` are indices of points.
ReportQuantities ChooseQuantities(const PointTable& table, const std::vector<uint32_t>& chosen,
                                  const QuantityLimits& limits);

// Returns whether ChooseQuantities can show the column of that name, or the page can color by it: `status`.
bool IsShownInReports(const PointTable& table, const std::string& column);

// Returns for each point its value of the column `status`; nothing if there is none, or it is no column of whole
// numbers from 0 to 255.
std::vector<uint8_t> StatusesOf(const PointTable& table);

}  // namespace curv
