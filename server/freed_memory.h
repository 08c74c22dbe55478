// What the process keeps of the memory that it freed.
#pragma once

#include <cstdint>

namespace curvd {

// Lets the heap keep freed buffers, 128 MiB at most and no more than an eighth of `memory_limit_bytes`. Messages of a
// MiB come and go all the time; returned to the system each time, their pages would be cleared for each message anew,
// which takes as long as reading it. Arrays of points are no part of it (core/page_array.h). To be called once, before
// threads exist; no effect where the C library is not GNU's.
void KeepFreedBuffers(uint64_t memory_limit_bytes);

}  // namespace curvd
