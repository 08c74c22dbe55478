#include "server/host/version.h"

namespace curvd {

const char* Version() { return CURVD_VERSION; }

}  // namespace curvd
