// Tells which curvd this is.
#pragma once

namespace curvd {

// MAJOR.MINOR.PATCH.
const char* Version();

}  // namespace curvd
