#include "bench/table.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace curvd::bench {

void Table::Finish(const std::string& folder) const {
  std::vector<size_t> widths(rows_[0].size());
  for (const auto& row : rows_) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::printf("\n%s\n", name_.c_str());
  for (const auto& row : rows_) {
    for (size_t i = 0; i < row.size(); ++i) absl::PrintF("  %-*s", static_cast<int>(widths[i]), row[i]);
    std::printf("\n");
  }
  std::fflush(stdout);
  if (folder.empty()) return;
  const std::string path = absl::StrCat(folder, "/", name_, ".csv");
  std::ofstream file(path);
  for (const auto& row : rows_) file << '"' << absl::StrJoin(row, "\",\"") << "\"\n";
  file.close();
  if (!file) {
    std::fprintf(stderr, "cannot write %s\n", path.c_str());
    std::exit(1);
  }
}

Targets::Targets(const std::string& program)
    : table_(absl::StrCat("targets_", program), {"target", "wanted", "measured", "met"}) {}

void Targets::AtLeast(const std::string& what, double wanted, double measured, const std::string& unit) {
  table_.AddRow({what, absl::StrCat("at least ", wanted, unit), absl::StrCat(Digits(measured), unit),
                 measured >= wanted ? "yes" : "**no**"});
}

void Targets::AtMost(const std::string& what, double wanted, double measured, const std::string& unit) {
  table_.AddRow({what, absl::StrCat("at most ", wanted, unit), absl::StrCat(Digits(measured), unit),
                 measured <= wanted ? "yes" : "**no**"});
}

std::string Digits(double value) {
  if (value >= 100.0) return absl::StrFormat("%.0f", value);
  return absl::StrFormat("%#.3g", value);
}

}  // namespace curvd::bench
