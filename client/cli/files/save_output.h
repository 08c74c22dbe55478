// Writes what a command made.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/cli/command.h"
#include "client/io/point_table.h"
#include "client/io/table_file.h"

namespace curv {

// Whether SaveOutput could write such a file, before anything is read: reports what is wrong, and returns kOutput, or
// kUsage if the format has no such form as flags ask for.
ExitCode CheckOutput(const std::string& output, const SaveOptions& options);

// SaveTable, with a note on what the table says beside its points that files of this format have no place for.
absl::Status SaveOutput(const PointTable& table, const std::string& output, const SaveOptions& options);

}  // namespace curv
