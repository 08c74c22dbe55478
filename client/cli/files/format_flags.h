// The flags that say how a command writes its file.
#pragma once

#include "client/io/table_file.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

// Adds --ascii to a command. `options` must outlive it.
void AddFormatFlags(CLI::App& command, SaveOptions& options);

}  // namespace curv
