#include "proto/http_date.h"

#include <gtest/gtest.h>

#include "absl/time/time.h"

namespace curvd {
namespace {

// The example of RFC 9110.
constexpr char kText[] = "Sun, 06 Nov 1994 08:49:37 GMT";
constexpr int64_t kSeconds = 784111777;

TEST(HttpDateTest, WritesTheExampleOfTheStandard) {
  EXPECT_EQ(FormatHttpDate(absl::FromUnixSeconds(kSeconds)), kText);
  EXPECT_EQ(FormatHttpDate(absl::FromUnixMillis(1000 * kSeconds + 999)), kText);
}

TEST(HttpDateTest, ReadsWhatItWrites) {
  ASSERT_TRUE(ParseHttpDate(kText).has_value());
  EXPECT_EQ(*ParseHttpDate(kText), absl::FromUnixSeconds(kSeconds));
  // Each day of four years, the 29th of February among them.
  for (int64_t day = 0; day < 1461; ++day) {
    const absl::Time time = absl::FromUnixSeconds(1'700'000'000 + 86'400 * day);
    ASSERT_EQ(ParseHttpDate(FormatHttpDate(time)), time) << FormatHttpDate(time);
  }
}

TEST(HttpDateTest, ReadsNothingElse) {
  for (const char* text :
       {"", "now", "Sun, 06 Nov 1994 08:49:37 UTC", "Sun, 06 Nov 1994 08:49:37 GMT ", "Sun, 31 Feb 1994 08:49:37 GMT",
        "Sun, 06 Now 1994 08:49:37 GMT", "Sun, 06 Nov 1994 24:49:37 GMT", "Sun, 06 Nov 1994 08:49:-7 GMT",
        "Sunday, 06-Nov-94 08:49:37 GMT"}) {
    EXPECT_FALSE(ParseHttpDate(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace curvd
