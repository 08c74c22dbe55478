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

v1::EstimatorOptions EstimatorFor(const EstimateOptions& options) {
  const std::vector<float> scalars(3);
  v1::EstimateCurvatureRequest request;
  EXPECT_TRUE(request.ParseFromString(Bytes(PackHeader(CloudView(scalars, scalars), options))));
  return request.header().options();
}

TEST(PackHeaderTest, TellsTheBoundsOfAnAutomaticScale) {
  EstimateOptions options;
  options.estimator = Estimator::kAuto;
  options.automatic_scale = AutomaticScale{32, 512, 0.25, true};
  const v1::EstimatorOptions told = EstimatorFor(options);
  EXPECT_EQ(told.estimator(), v1::ESTIMATOR_AUTO);
  ASSERT_TRUE(told.has_automatic_scale());
  EXPECT_EQ(told.automatic_scale().least_neighbor_count(), 32u);
  EXPECT_EQ(told.automatic_scale().most_neighbor_count(), 512u);
  EXPECT_EQ(told.automatic_scale().max_radius(), 0.25);
  EXPECT_TRUE(told.automatic_scale().per_cloud());
}

TEST(PackHeaderTest, AnAutomaticScaleIsToldEvenIfItHasNoBounds) {
  EstimateOptions options;
  options.automatic_scale.emplace();
  options.radius = 2.0;
  EXPECT_TRUE(EstimatorFor(options).has_automatic_scale()) << "instead of count and radius";
  EXPECT_EQ(EstimatorFor(options).automatic_scale().SerializeAsString(), "");
  EXPECT_EQ(EstimatorFor({}).neighbor_count(), 50u);
}

TEST(PackHeaderTest, LeavesTheDegreeOfJetsToTheServerUnlessItIsGiven) {
  EstimateOptions options;
  EXPECT_EQ(EstimatorFor(options).jet_degree(), 0u);
  options.jet_degree = 2;
  EXPECT_EQ(EstimatorFor(options).jet_degree(), 2u);
}

TEST(PackHeaderTest, CarriesTheDegreeOfRegressions) {
  EstimateOptions options;
  EXPECT_EQ(EstimatorFor(options).regression_degree(), 3u);
  options.regression_degree = 2;
  EXPECT_EQ(EstimatorFor(options).regression_degree(), 2u);
}

TEST(PackHeaderTest, CarriesProjecting) {
  EstimateOptions options;
  EXPECT_FALSE(EstimatorFor(options).project());
  options.project = true;
  EXPECT_TRUE(EstimatorFor(options).project());
}

TEST(PackChunkTest, LeavesOutWhatTheCloudDoesNotHave) {
  const std::vector<float> positions = {1, 2, 3, 4, 5, 6}, viewpoints = {7, 8, 9, 10, 11, 12};
  v1::EstimateCurvatureRequest request;
  request.mutable_chunk()->set_first_index(1);
  request.mutable_chunk()->set_positions(&positions[3], 12);
  const CloudView bare(positions);
  EXPECT_EQ(Bytes(PackChunk(bare, 1, 1)), request.SerializeAsString());
  request.mutable_chunk()->set_viewpoints(&viewpoints[3], 12);
  EXPECT_EQ(Bytes(PackChunk(bare.SeenFrom(viewpoints), 1, 1)), request.SerializeAsString());
}

TEST(PackHeaderTest, TellsTheDirectionOfAllPointsOrTheChunksThoseOfEach) {
  const std::vector<float> positions = {1, 2, 3, 4, 5, 6}, directions = {7, 8, 9, 10, 11, 12};
  EstimateOptions options;
  options.quantities = {"normal_curvature"};
  v1::EstimateCurvatureRequest request;
  ASSERT_TRUE(request.ParseFromString(Bytes(PackHeader(CloudView(positions), options))));
  EXPECT_FALSE(request.header().has_curvature_direction());
  options.curvature_direction = {1.0, 2.0, 3.0};
  ASSERT_TRUE(request.ParseFromString(Bytes(PackHeader(CloudView(positions), options))));
  EXPECT_EQ(request.header().curvature_direction().z(), 3.0);
  v1::EstimateCurvatureRequest chunk;
  chunk.mutable_chunk()->set_first_index(1);
  chunk.mutable_chunk()->set_positions(&positions[3], 12);
  chunk.mutable_chunk()->set_curvature_directions(&directions[3], 12);
  EXPECT_EQ(Bytes(PackChunk(CloudView(positions).Toward(directions), 1, 1)), chunk.SerializeAsString());
}

v1::NormalOptions NormalsFor(const NormalOptions& normals) {
  const std::vector<float> scalars(3);
  EstimateOptions options;
  options.normals = normals;
  v1::EstimateCurvatureRequest request;
  EXPECT_TRUE(request.ParseFromString(Bytes(PackHeader(CloudView(scalars, scalars), options))));
  return request.header().normals();
}

TEST(PackHeaderTest, SaysNothingOfNormalsThatAreGiven) {
  EXPECT_EQ(NormalsFor({}).SerializeAsString(), "");
  EXPECT_EQ(NormalsFor({.sides = SidesAlongDirection{{0, 0, 1}}}).SerializeAsString(), "") << "it has no effect";
}

TEST(PackHeaderTest, TellsHowNormalsAreMade) {
  const v1::NormalOptions chosen = NormalsFor({.source = NormalSource::kEstimate});
  EXPECT_EQ(chosen.source(), v1::NORMAL_SOURCE_ESTIMATE);
  EXPECT_EQ(chosen.method(), v1::NORMAL_METHOD_UNSPECIFIED);
  EXPECT_EQ(chosen.neighborhood_case(), v1::NormalOptions::NEIGHBORHOOD_NOT_SET);
  EXPECT_EQ(chosen.orientation(), v1::ORIENTATION_CONSISTENT);
  const v1::NormalOptions own =
      NormalsFor({.source = NormalSource::kEstimate, .method = NormalMethod::kPca, .neighbor_count = 12});
  EXPECT_EQ(own.method(), v1::NORMAL_METHOD_PCA);
  EXPECT_EQ(own.neighbor_count(), 12u);
  EXPECT_EQ(NormalsFor({.source = NormalSource::kEstimate, .radius = 0.5}).radius(), 0.5);
  EXPECT_FALSE(NormalsFor({.source = NormalSource::kOrient, .radius = 0.5}).has_radius()) << "it has no effect";
}

TEST(PackHeaderTest, TellsWhichSideIsOut) {
  const auto toward = [](const auto& sides) { return NormalsFor({.source = NormalSource::kOrient, .sides = sides}); };
  EXPECT_EQ(toward(ConsistentSides{.closed = true}).orientation(), v1::ORIENTATION_CLOSED);
  EXPECT_EQ(toward(SidesTowardViewpoints()).orientation(), v1::ORIENTATION_POINT_VIEWPOINTS);
  const v1::NormalOptions one = toward(SidesTowardViewpoint{{1, 2, 3}});
  EXPECT_EQ(one.orientation(), v1::ORIENTATION_VIEWPOINT);
  EXPECT_EQ(one.viewpoint().y(), 2.0);
  const v1::NormalOptions along = toward(SidesAlongDirection{{4, 5, 6}});
  EXPECT_EQ(along.orientation(), v1::ORIENTATION_DIRECTION);
  EXPECT_EQ(along.direction().z(), 6.0);
}

}  // namespace
}  // namespace curv
