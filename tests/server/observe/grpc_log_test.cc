#include "server/observe/grpc_log.h"

#include <gmock/gmock.h>
#include <grpc/grpc.h>
#include <grpc/support/log.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace curvd {
namespace {

class GrpcLogRouteTest : public ::testing::Test {
 protected:
  GrpcLogRouteTest() { grpc_init(); }
  ~GrpcLogRouteTest() override { grpc_shutdown(); }
};

TEST_F(GrpcLogRouteTest, PutsGrpcsErrorsIntoTheLogAFewASecond) {
  ::testing::internal::CaptureStderr();
  {
    ServerLog log(false);
    const GrpcLogRoute route(log);
    gpr_log("/src/core/somewhere.cc", 7, GPR_LOG_SEVERITY_ERROR, "%s", "a \"quoted\" line");
    for (int i = 0; i < 1'000; ++i) gpr_log("/src/core/flood.cc", 7, GPR_LOG_SEVERITY_ERROR, "%s", "again");
  }
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, ::testing::HasSubstr("\"level\":\"warning\",\"event\":\"grpc\",\"source\":\"somewhere.cc\","
                                         "\"message\":\"a \\\"quoted\\\" line\"}"));
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 200);
}

TEST_F(GrpcLogRouteTest, AsksForNoMoreThanGrpcWouldPrint) {
  const bool prints_info = gpr_should_log(GPR_LOG_SEVERITY_INFO) != 0;
  ServerLog log(false);
  const GrpcLogRoute route(log);
  EXPECT_EQ(gpr_should_log(GPR_LOG_SEVERITY_INFO) != 0, prints_info);
  EXPECT_FALSE(gpr_should_log(GPR_LOG_SEVERITY_DEBUG));
}

}  // namespace
}  // namespace curvd
