// Holds the page that reports are written into, which client/report/build.mjs makes of client/report/page/.
#pragma once

#include <string_view>

namespace curv {

// Returns the page; @curv-report@ stands once where the report's JSON goes, @curv-points@ once, after it, where its
// points go.
std::string_view PageTemplate();

}  // namespace curv
