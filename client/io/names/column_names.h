// Says what columns are called in tables, and in the headers of files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// Returns what tables call a coordinate of the position or the normal, in whatever spelling a file has it: x for X; nx
// for Nx, normal_x, NormalX and n_x, in upper and lower case. Other names stay as they are.
std::string TableName(std::string_view spelling);

// Returns TableName of each spelling. INVALID_ARGUMENT if two of them are the same; the message calls them `what`.
absl::StatusOr<std::vector<std::string>> TableNames(const std::vector<std::string>& spellings, const char* what);

// Returns a name for each column of a table, made by `clean`, of which no two are the same when they are read again:
// where they would be, one is NAME_2, NAME_3 and so on. Positions and normals keep theirs, and so do those columns
// before others that `clean` leaves as they are. What `clean` leaves empty becomes "column".
std::vector<std::string> HeaderNames(const PointTable& table, std::string (*clean)(std::string_view name));

}  // namespace curv
