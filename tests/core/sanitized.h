// Whether a sanitizer looks on.
#pragma once

#include <cstddef>

namespace curvd::testing {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

// How much fewer points of a result are compared with an oracle's, whose plain arithmetic takes most of such a test's
// time and which no sanitizer needs to see. The kernels are run over all points.
inline constexpr size_t kSparser = kSanitized ? 4 : 1;

}  // namespace curvd::testing
