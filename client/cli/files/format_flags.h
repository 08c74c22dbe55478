// The flags that say in which format a command reads and writes its files.
#pragma once

#include <cstdio>
#include <string>

#include "client/io/table_file.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace curv {

// Adds --format to a command that reads. `format` must outlive it.
void AddInputFormat(CLI::App& command, std::string& format);

// Adds --format, --ascii and --names to a command that writes. `options` must outlive it.
void AddOutputFormat(CLI::App& command, SaveOptions& options);

// Adds them to a command that does both, and --input-format and --output-format, which count for one end in place of
// --format. Both must outlive it.
void AddFormats(CLI::App& command, std::string& input_format, SaveOptions& options);

// Adds the required -o to a command that writes a cloud. Other names of standard output become "-": as a file it would
// be replaced, and share its place with the summary. `output` must outlive the command.
CLI::Option* AddOutput(CLI::App& command, std::string& output, const std::string& help);

// Returns where a summary goes: to standard output, unless the result goes there.
std::FILE* SummaryStream(const std::string& output);

}  // namespace curv
