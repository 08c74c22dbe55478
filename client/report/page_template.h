// Holds the page that reports are written into, which client/report/build.mjs makes of client/report/page/.
#pragma once

#include <string_view>

namespace curv {

// Returns the page. @curv-connect@ stands once, where its policy may allow requests ("connect-src 'self'; ", or
// nothing); @curv-report@ once, after that, where the report's JSON goes; @curv-points@ once, at last, where its points
// go.
std::string_view PageTemplate();

}  // namespace curv
