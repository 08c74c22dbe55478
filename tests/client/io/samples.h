// Small files in memory, and what every reader must survive.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

using Reader = absl::StatusOr<PointTable> (*)(std::string_view);

// Bytes of scalars as they lie in memory.
template <typename... Scalars>
std::string Pack(Scalars... scalars) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&scalars), sizeof(scalars)), ...);
  return bytes;
}

// The same with each scalar's bytes reversed.
template <typename... Scalars>
std::string PackSwapped(Scalars... scalars) {
  std::string bytes;
  const auto append = [&bytes](auto scalar) {
    const std::string packed = Pack(scalar);
    bytes.append(packed.rbegin(), packed.rend());
  };
  (append(scalars), ...);
  return bytes;
}

// The column's values; empty if the table has no such column.
std::vector<double> Values(const PointTable& table, std::string_view name);

// Reads every proper prefix of `file`, and `file` with single bytes changed: each must give a table or an error with a
// message, whatever sanitizers watch. Returns the number of prefixes that were accepted.
int AcceptedPrefixes(Reader reader, const std::string& file);

}  // namespace curv
