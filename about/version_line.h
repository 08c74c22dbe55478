// Tells which build of a program this is, as --version prints it.
#pragma once

#include <string>

namespace curvd {

// "curv 0.1.0 (commit 4eb9522a1c0d)" of the program "curv"; "-dirty" is appended to the commit where files differed
// from it. "curv 0.1.0 (not built in a git clone)" of a build of a tarball; "(commit unknown)" where git was not to be
// asked.
std::string VersionLine(const std::string& program);

}  // namespace curvd
