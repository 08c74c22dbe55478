// Tells and raises how many files and sockets this process may have open.
#pragma once

#include <cstddef>

namespace curvd {

// Raises the limit to what the system lets this process have. A setting of the process: for main.
void RaiseDescriptorLimit();

// At most `wanted`, and no more than leaves a tenth of the process's descriptors for files, the metrics port and gRPC.
// A connection has two descriptors: gRPC's, and the watch of the ConnectionRegistry.
size_t ConnectionsWithin(size_t wanted);

}  // namespace curvd
