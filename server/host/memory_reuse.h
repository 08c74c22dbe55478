// Lets the process use the memory that it freed again, instead of returning it to the system.
#pragma once

#include <cstdint>

namespace curvd {

// The system clears each page that it hands out. If pages went back with every call, that would take as long as reading
// a message, and 3 to 6 % of the time of an estimate.
//
// Lets the heap keep freed buffers, 128 MiB at most and no more than an eighth of `memory_limit_bytes`: messages of a
// MiB come and go all the time. Lets the process keep pages of arrays of points, 128 MiB at most and no more than a
// sixteenth of the limit, as long as they and the arrays in use stay below seven eighths of it. To be called once,
// before threads exist; no effect on the heap where the C library is not GNU's.
void ReuseFreedMemory(uint64_t memory_limit_bytes);

// Gives pages back to the system that no array has used for 10 seconds. To be called now and then.
void ReturnUnusedPages();

}  // namespace curvd
