#include "server/rpc/request_ids.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

TEST(RequestIdsTest, CountsBehindAPrefixOfItsOwn) {
  RequestIds ids;
  const std::string first = ids.Next();
  ASSERT_EQ(first.size(), 10u);
  EXPECT_EQ(first.substr(8), "-1");
  EXPECT_EQ(ids.Next(), first.substr(0, 8) + "-2");
}

}  // namespace
}  // namespace curvd
