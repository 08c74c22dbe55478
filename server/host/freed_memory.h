// What the process keeps of the memory that it freed.
#pragma once

#include <cstdint>

namespace curvd {

// Returned to the system with every call, pages would be cleared for every call anew, which takes as long as reading a
// message and 3 to 6 % of the time of an estimate.
//
// Lets the heap keep freed buffers, 128 MiB at most and no more than an eighth of `memory_limit_bytes`: messages of a
// MiB come and go all the time. Lets the process keep pages of arrays of points, 128 MiB at most and no more than a
// sixteenth of the limit, as long as they and the arrays in use stay below seven eighths of it. To be called once,
// before threads exist; no effect on the heap where the C library is not GNU's.
void KeepFreedMemory(uint64_t memory_limit_bytes);

// Gives pages back to the system that no array has used for 10 seconds. To be called now and then.
void ReleaseFreedPages();

}  // namespace curvd
