#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/names/column_names.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

// The places of the columns in a table, in the order of a file: readers take the first three for x, y and z.
std::vector<size_t> OrderInFile(const PointTable& table) {
  std::vector<size_t> order;
  for (const std::string_view axis : {"x", "y", "z"}) {
    const Column* const column = table.Find(axis);
    if (column != nullptr) order.push_back(static_cast<size_t>(column - table.columns().data()));
  }
  for (size_t i = 0; i < table.columns().size(); ++i) {
    const std::string& name = table.columns()[i].name;
    if (name != "x" && name != "y" && name != "z") order.push_back(i);
  }
  return order;
}

}  // namespace

std::string XyzHead(const PointTable& like, uint64_t /*rows*/) {
  const std::vector<std::string> names = HeaderNames(like, HeaderName);
  std::string header = "#";
  for (const size_t i : OrderInFile(like)) header += ' ' + names[i];
  return header + '\n';
}

absl::Status AppendXyzRows(const PointTable& table, ByteSink& file) {
  std::vector<const Column*> columns;
  for (const size_t i : OrderInFile(table)) columns.push_back(&table.columns()[i]);
  return AppendTextRows(columns, ' ', /*status_words=*/false, file);
}

absl::Status WriteXyz(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(XyzHead(table, table.size())); !status.ok()) return status;
  return AppendXyzRows(table, file);
}

}  // namespace curv
