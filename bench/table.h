// Tables for the terminal and, as CSV, for docs/benchmarks.md.
#pragma once

#include <string>
#include <vector>

namespace curvd::bench {

class Table {
 public:
  // `name` is the CSV file's, and that of the table's place in docs/benchmarks.md.
  Table(std::string name, std::vector<std::string> columns) : name_(std::move(name)), rows_{std::move(columns)} {}

  // REQUIRES: one cell for each column, without quotes in it.
  void AddRow(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

  // Prints the table and, unless `folder` is empty, writes folder/name.csv. Ends the program if that fails.
  void Finish(const std::string& folder) const;

 private:
  std::string name_;
  std::vector<std::vector<std::string>> rows_;
};

// What was wanted and what was measured.
class Targets {
 public:
  explicit Targets(const std::string& program);

  void AtLeast(const std::string& what, double wanted, double measured, const std::string& unit);
  void AtMost(const std::string& what, double wanted, double measured, const std::string& unit);
  // The machine cannot tell: `why` stands in place of a figure.
  void NotMeasurable(const std::string& what, const std::string& wanted, const std::string& why) {
    table_.AddRow({what, wanted, why, "not measurable"});
  }
  void Finish(const std::string& folder) const { table_.Finish(folder); }

 private:
  Table table_;
};

// With three significant digits.
std::string Digits(double value);

}  // namespace curvd::bench
