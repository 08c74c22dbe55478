// How much of the address space each thread of this process takes for its stack.
#pragma once

namespace curvd {

// Gives threads that start from now on 2 MiB each, gRPC's included, in place of the system's usual 8 MiB: curvd has
// about 50 threads, none of which calls deeply, and where the address space is limited (`ulimit -v`) clouds need it
// more. A setting of the process: for main.
void LimitThreadStacks();

}  // namespace curvd
