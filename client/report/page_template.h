// Holds the page that reports are written into, which client/report/build.mjs makes of client/report/page/, and what
// pages of compressed points have beside it, made of client/report/laz/.
#pragma once

#include <string_view>

namespace curv {

// Returns the page. Each of these stands once in it, in this order: @curv-connect@, where its policy may allow requests
// ("connect-src 'self'; ", or nothing); @curv-codec-policy@, where it may allow one more script; @curv-report@, where
// the report's JSON goes; @curv-points@, where its points go; @curv-codec@, where that script goes.
std::string_view PageTemplate();

// Returns the codec: a line for @curv-codec-policy@, then elements for @curv-codec@.
std::string_view LazCodec();

}  // namespace curv
