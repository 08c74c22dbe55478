// Finds clouds whose coordinates lost in floats what lies between their points.
#pragma once

#include <string>

#include "client/io/oriented_cloud.h"

namespace curv {

// Returns a sentence for the user if the positions are floats so far from zero that neighboring floats lie an eighth of
// the distance between points apart, or more; else nothing. That distance is judged by the extent of all but the
// outermost tenth of the cloud on each axis, as if the points lay evenly on a surface. Clouds of fewer than 100 points
// tell nothing.
std::string NoteOnCoarsePositions(const OrientedCloud& cloud);

}  // namespace curv
