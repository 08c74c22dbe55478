#include "server/net/metrics_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "server/observe/server_metrics.h"

namespace curvd {
namespace {

TEST(MetricsPortTest, PicksAFreePort) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto port = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(port.ok()) << port.status();
  EXPECT_GT((*port)->port(), 0);
}

TEST(MetricsPortTest, NamesAnAddressThatItCannotBind) {
  const ServerMetrics metrics([] { return ServerGauges(); });
  const auto first = MetricsPort::Create("127.0.0.1:0", metrics.collectables());
  ASSERT_TRUE(first.ok());
  const std::string address = absl::StrCat("127.0.0.1:", (*first)->port());
  for (const std::string& listen : {address, std::string("no address")}) {
    const auto second = MetricsPort::Create(listen, metrics.collectables());
    EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(std::string(second.status().message()), ::testing::HasSubstr(listen));
  }
}

}  // namespace
}  // namespace curvd
