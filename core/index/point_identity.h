// What a point's rank, the number beside it in the index, says about it. All three are the same number as long as every
// cloud comes whole; whoever means one of them says which.
#pragma once

#include <cstddef>
#include <cstdint>

namespace curvd {

// Whether the point is estimated; otherwise it is a neighbor of others alone.
constexpr bool IsQuery(int32_t /*rank*/) { return true; }

// What the random strategies draw by, so that a point's triangles depend on nothing but the point.
constexpr uint64_t SeedOf(int32_t rank) { return static_cast<uint64_t>(rank); }

// Where the point's result goes.
constexpr size_t SlotOf(int32_t rank) { return static_cast<size_t>(rank); }

}  // namespace curvd
