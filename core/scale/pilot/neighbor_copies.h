// Finds the neighbors of a point that tell nothing new.
#pragma once

#include <cstdint>

#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// A neighbor that has the position of another one with a lower id is a copy: it tells nothing new, since both share
// their noise. So are those that are much nearer to another one than points are to each other (core/base/copies.h), if
// they are too many for chance. Finds the copies among the neighbors that `order` lists by their `squared` distances,
// and equal ones by their ids: the ids of copies become the complement of the first one's.
void MarkCopies(PilotScratch& s);
inline bool IsCopy(int32_t id) { return id < 0; }
inline int32_t FirstOfCopies(int32_t id) { return IsCopy(id) ? ~id : id; }

}  // namespace curvd
