#include "about/version_line.h"

#include "commit.h"

namespace curvd {

std::string VersionLine(const std::string& program) { return program + " " CURVD_VERSION " (" + kCommit + ")"; }

}  // namespace curvd
