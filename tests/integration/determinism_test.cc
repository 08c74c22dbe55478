// The same cloud and options give the same bytes, however they are computed and sent.
#include <gtest/gtest.h>

#include <string>

#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

class DeterminismTest : public ::testing::TestWithParam<v1::Estimator> {
 protected:
  static CallResult Run(const TestServer& server, const TestCloud& cloud, size_t chunk_points) {
    v1::CloudHeader header = HeaderFor(cloud, 30);
    header.mutable_options()->set_estimator(GetParam());
    header.mutable_options()->set_seed(7);
    return Estimate(server.NewChannel(), header, cloud, chunk_points);
  }
};

TEST_P(DeterminismTest, ThreadsAndChunkSizesDoNotMatter) {
  const TestCloud small = Torus(1'000), large = Torus(70'000);
  std::string small_bytes, large_bytes;
  for (const int threads : {1, 2, 8}) {
    TestServer server([threads](ServerOptions& options) {
      options.threads = threads;
      options.metrics_listen = "";
    });
    for (const size_t chunk_points : {1, 1'000, 65'536}) {
      const TestCloud& cloud = chunk_points == 1 ? small : large;
      std::string& expected = chunk_points == 1 ? small_bytes : large_bytes;
      const CallResult result = Run(server, cloud, chunk_points);
      ASSERT_TRUE(Succeeded(result, cloud.size())) << threads << " threads, chunks of " << chunk_points;
      if (expected.empty()) expected = result.AllBytes();
      EXPECT_TRUE(result.AllBytes() == expected) << threads << " threads, chunks of " << chunk_points;
    }
    EXPECT_TRUE(Run(server, small, 1'000).AllBytes() == small_bytes) << threads << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(Estimators, DeterminismTest,
                         ::testing::Values(v1::ESTIMATOR_AVG_HEXAGRAM, v1::ESTIMATOR_HEXAGRAM, v1::ESTIMATOR_UNIFORM,
                                           v1::ESTIMATOR_INDEPENDENT, v1::ESTIMATOR_DELAUNAY, v1::ESTIMATOR_JET_FITTING,
                                           v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR, v1::ESTIMATOR_NORMAL_REGRESSION,
                                           v1::ESTIMATOR_AUTO),
                         [](const auto& info) { return v1::Estimator_Name(info.param); });

}  // namespace
}  // namespace curvd
