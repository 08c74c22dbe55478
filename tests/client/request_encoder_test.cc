#include "client/request_encoder.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "curvature/v1/curvature.pb.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;

std::string Bytes(const grpc::Slice& slice) { return {slice.begin(), slice.end()}; }

TEST(PackChunkTest, HasTheBytesOfProtobuf) {
  std::vector<double> positions(3 * 1000), normals(3 * 1000);
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i] = static_cast<double>(i);
    normals[i] = -static_cast<double>(i);
  }
  const CloudView cloud(positions, normals);
  for (const size_t first : {0, 1, 500}) {
    for (const size_t count : {1, 7, 500}) {
      v1::EstimateCurvatureRequest request;
      request.mutable_chunk()->set_first_index(first);
      request.mutable_chunk()->set_positions(&positions[3 * first], 3 * count * sizeof(double));
      request.mutable_chunk()->set_normals(&normals[3 * first], 3 * count * sizeof(double));
      EXPECT_EQ(Bytes(PackChunk(cloud, first, count)), request.SerializeAsString()) << first << " + " << count;
    }
  }
}

TEST(PackHeaderTest, TellsTheOptions) {
  const std::vector<float> scalars(3 * 17);
  EstimateOptions options;
  options.estimator = Estimator::kJetFitting;
  options.radius = 0.25;
  options.origin = {1.0, 2.0, 3.0};
  options.skip_invalid = true;
  options.reject_opposed_normals = true;
  options.request_tag = "tag";
  options.priority = Priority::kBatch;
  options.quantities = {"radius", "mean_curvature"};
  v1::EstimateCurvatureRequest request;
  ASSERT_TRUE(request.ParseFromString(Bytes(PackHeader(CloudView(scalars, scalars), options))));
  const v1::CloudHeader& header = request.header();
  EXPECT_EQ(header.point_count(), 17u);
  EXPECT_EQ(header.scalar_type(), v1::SCALAR_TYPE_FLOAT32);
  EXPECT_EQ(header.options().estimator(), v1::ESTIMATOR_JET_FITTING);
  EXPECT_EQ(header.options().radius(), 0.25);
  EXPECT_EQ(header.origin().z(), 3.0);
  EXPECT_EQ(header.invalid_point_policy(), v1::INVALID_POINT_POLICY_SKIP);
  EXPECT_EQ(header.opposed_normals_policy(), v1::OPPOSED_NORMALS_POLICY_REJECT);
  EXPECT_EQ(header.request_tag(), "tag");
  EXPECT_EQ(header.priority(), v1::PRIORITY_BATCH);
  ASSERT_EQ(header.quantities_size(), 2);
  EXPECT_EQ(header.quantities(0), v1::QUANTITY_RADIUS);
  EXPECT_EQ(header.quantities(1), v1::QUANTITY_MEAN_CURVATURE);
}

}  // namespace
}  // namespace curv
