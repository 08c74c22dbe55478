#include "tests/client/io/samples.h"

#include <gtest/gtest.h>

namespace curv {
namespace {

bool IsHandled(const absl::StatusOr<PointTable>& table) {
  if (!table.ok()) return absl::IsInvalidArgument(table.status()) && !table.status().message().empty();
  for (const Column& column : table->columns()) {
    if (column.size() != table->size()) return false;
  }
  return true;
}

}  // namespace

std::vector<double> Values(const PointTable& table, std::string_view name) {
  std::vector<double> values;
  const Column* column = table.Find(name);
  for (size_t i = 0; column != nullptr && i < column->size(); ++i) values.push_back(column->At(i));
  return values;
}

int AcceptedPrefixes(Reader reader, const std::string& file) {
  int accepted = 0;
  for (size_t size = 0; size < file.size(); ++size) {
    // A copy of its own, so that reading past its end is seen.
    const std::string prefix(file, 0, size);
    const absl::StatusOr<PointTable> table = reader(prefix);
    EXPECT_TRUE(IsHandled(table)) << "prefix of " << size << " bytes: " << table.status();
    accepted += table.ok() ? 1 : 0;
  }
  for (size_t at = 0; at < file.size(); ++at) {
    for (const char change : {'\x00', '\x7f', '\xff', '9', '-', '\n'}) {
      std::string damaged = file;
      damaged[at] = change;
      EXPECT_TRUE(IsHandled(reader(damaged))) << "byte " << at << " set to " << static_cast<int>(change);
    }
  }
  return accepted;
}

}  // namespace curv
