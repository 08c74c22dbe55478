// Writes what a command made.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/io/point_table.h"
#include "client/io/table_file.h"

namespace curv {

// SaveTable, with a note on what the table says beside its points that files of this format have no place for.
absl::Status SaveOutput(const PointTable& table, const std::string& output, const SaveOptions& options);

}  // namespace curv
