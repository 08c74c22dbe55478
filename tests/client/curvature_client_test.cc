#include "client/curvature_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stop_token>
#include <string_view>
#include <vector>

#include "tests/client/local_server.h"
#include "tests/client/sphere_cloud.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

TEST(CurvatureClientTest, NamesEveryEstimator) {
  const std::span<const std::string_view> names = EstimatorNames();
  for (size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(EstimatorName(static_cast<Estimator>(i + 1)), names[i]);
    EXPECT_EQ(EstimatorOf(names[i]), static_cast<Estimator>(i + 1));
  }
  EXPECT_EQ(EstimatorOf("best"), std::nullopt);
}

TEST(CurvatureClientTest, ServerKnowsEveryEstimator) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(500);
  for (const std::string_view name : EstimatorNames()) {
    EstimateOptions options;
    options.estimator = *EstimatorOf(name);
    const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), options);
    ASSERT_TRUE(result.ok()) << name << ": " << result.status();
    EXPECT_EQ(result->summary.status_counts[1], 500u) << name;
  }
  const auto info = client->GetServerInfo(absl::Seconds(10));
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_THAT(info->estimators, ::testing::ElementsAreArray(EstimatorNames().begin(), EstimatorNames().end()));
}

TEST(CurvatureClientTest, JetDegreeReachesTheServer) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(500);
  EstimateOptions options;
  options.estimator = Estimator::kJetFitting;
  options.neighbor_count = 14;  // one less than a polynomial of degree 4 has coefficients
  options.jet_degree = 4;
  const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.status_counts[static_cast<size_t>(PointStatus::kSingularFit)], 500u);
}

TEST(CurvatureClientTest, EstimatesACloudWithoutNormals) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(5000);
  EstimateOptions options;
  const CloudView bare(sphere.points);
  const absl::StatusOr<CurvatureResult> refused = client->Estimate(bare, options);
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status()));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("options.normals.source to kEstimate"));

  options.normals.source = NormalSource::kEstimate;
  const absl::StatusOr<CurvatureResult> result = client->Estimate(bare, options);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->normals.size(), 15'000u);
  EXPECT_EQ(result->mean.size(), 5000u);
  for (size_t i = 0; i < 3 * 5000; i += 997) EXPECT_NEAR(result->normals[i], sphere.points[i], 0.02);
  ASSERT_TRUE(result->summary.normals.has_value());
  EXPECT_EQ(result->summary.normals->closed_pieces, 1u);
  EXPECT_GT(result->summary.normals_seconds, 0.0);

  const absl::StatusOr<CurvatureResult> both = client->Estimate(sphere.view(), options);
  EXPECT_TRUE(absl::IsInvalidArgument(both.status()));
  EXPECT_THAT(std::string(both.status().message()), HasSubstr("options.normals.source asks for estimated ones"));
}

TEST(CurvatureClientTest, TurnsNormalsAndNothingElseOnRequest) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(2000);
  std::vector<float> mixed = sphere.points;
  for (size_t i = 0; i < 3 * 500; ++i) mixed[i] = -mixed[i];
  EstimateOptions options;
  options.quantities = {"normals"};
  options.normals.source = NormalSource::kOrient;
  const absl::StatusOr<CurvatureResult> result = client->Estimate(CloudView(sphere.points, mixed), options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->mean.empty());
  EXPECT_EQ(result->summary.estimate_seconds, 0.0);
  for (size_t i = 0; i < mixed.size(); ++i) ASSERT_NEAR(result->normals[i], sphere.points[i], 1e-6);
}

TEST(CurvatureClientTest, ViewpointsMustBeAskedForAndAsManyAsPoints) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(2000);
  const CloudView bare(sphere.points);
  EstimateOptions options;
  options.quantities = {"normals"};
  options.normals.source = NormalSource::kEstimate;
  EXPECT_THAT(std::string(client->Estimate(bare.SeenFrom(sphere.points), options).status().message()),
              HasSubstr("only SidesTowardViewpoints"));
  options.normals.sides = SidesTowardViewpoints();
  EXPECT_THAT(std::string(client->Estimate(bare, options).status().message()), HasSubstr("viewpoints 0"));
  const std::vector<float> inside(3 * 2000);
  const absl::StatusOr<CurvatureResult> result = client->Estimate(bare.SeenFrom(inside), options);
  ASSERT_TRUE(result.ok()) << result.status();
  for (size_t i = 0; i < 3 * 2000; i += 997) EXPECT_NEAR(result->normals[i], -sphere.points[i], 0.05);
}

TEST(CurvatureClientTest, TellsHowSureValuesAreAndWhatWasChosen) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(2000);
  EstimateOptions options;
  options.estimator = Estimator::kAuto;
  options.automatic_scale.emplace();
  options.quantities = DefaultQuantityNames();
  EXPECT_EQ(options.quantities.size(), 5u);
  for (const char* more : {"standard_errors", "chosen_neighbor_count", "estimator_weights"}) {
    options.quantities.emplace_back(more);
  }
  const absl::StatusOr<CurvatureResult> result = client->Estimate(CloudView(sphere.points, sphere.points), options);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->mean_standard_error.size(), 2000u);
  EXPECT_GT(result->mean_standard_error[7], 0.0f);
  EXPECT_GT(result->k1_standard_error[7], 0.0f);
  EXPECT_GT(result->k2_standard_error[7], 0.0f);
  EXPECT_GE(result->chosen_neighbor_count[7], 16.0f);
  EXPECT_NEAR(result->avg_hexagram_weight[7] + result->normal_regression_weight[7] + result->jet_weight[7] +
                  result->aso_weight[7],
              1.0f, 1e-5f);
  ASSERT_TRUE(result->summary.scale.has_value());
  EXPECT_TRUE(result->summary.scale->normal_noise.has_value());
  EXPECT_TRUE(result->others.empty());
}

TEST(CurvatureClientTest, TellsWhatGivenNormalsWereMadeBy) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  SphereCloud sphere = Sphere(4000);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0f, 0.01f);
  for (float& coordinate : sphere.points) coordinate += noise(random);
  EstimateOptions make;
  make.quantities = {"normals"};
  make.normals.source = NormalSource::kEstimate;
  make.normals.method = NormalMethod::kPca;
  make.normals.neighbor_count = 20;
  const absl::StatusOr<CurvatureResult> made = client->Estimate(CloudView(sphere.points), make);
  ASSERT_TRUE(made.ok()) << made.status();
  EstimateOptions options;
  options.estimator = Estimator::kAuto;
  options.automatic_scale.emplace();
  const auto result = client->Estimate(CloudView(sphere.points, made->normals), options);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->summary.scale.has_value() && result->summary.scale->fitted_normals.has_value());
  EXPECT_EQ(result->summary.scale->fitted_normals->method, NormalMethod::kPca);
  EXPECT_EQ(result->summary.scale->fitted_normals->neighbor_count, 20u);
  ASSERT_TRUE(result->summary.scale->normals_made_anew.has_value());
  EXPECT_GT(result->summary.scale->normals_made_anew->neighbor_count, 20u);
}

TEST(CurvatureClientTest, NormalCurvatureTakesOneDirectionOrOneForEachPoint) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(2000);
  const CloudView cloud(sphere.points, sphere.points);
  EstimateOptions options;
  options.quantities = {"normal_curvature"};
  EXPECT_THAT(std::string(client->Estimate(cloud, options).status().message()), HasSubstr("directions 0"));
  std::vector<float> directions(3 * 2000);
  for (size_t i = 2; i < directions.size(); i += 6) directions[i] = 1.0f;  // every other point
  const absl::StatusOr<CurvatureResult> each = client->Estimate(cloud.Toward(directions), options);
  ASSERT_TRUE(each.ok()) << each.status();
  EXPECT_NEAR(each->normal_curvature[1000], 1.0, 0.05);
  EXPECT_TRUE(std::isnan(each->normal_curvature[1001])) << "it has no direction";
  options.curvature_direction = {0.0, 0.0, 1.0};
  EXPECT_THAT(std::string(client->Estimate(cloud.Toward(sphere.points), options).status().message()),
              HasSubstr("without options.curvature_direction"));
  const absl::StatusOr<CurvatureResult> one = client->Estimate(cloud, options);
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_NEAR(one->normal_curvature[1000], 1.0, 0.05);
}

TEST(CurvatureClientTest, WarnsOfOpposedNormalsOrRefusesThem) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud sphere = Sphere(2000);
  std::vector<float> normals = sphere.points;
  for (size_t i = 0; i < normals.size(); ++i) normals[i] *= sphere.points[i - i % 3] > 0.0f ? -1.0f : 1.0f;
  const CloudView cloud(sphere.points, normals);
  const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud, {});
  ASSERT_TRUE(result.ok()) << result.status();
  const uint64_t opposed = result->summary.status_counts[static_cast<size_t>(PointStatus::kOpposedNormals)];
  EXPECT_GT(opposed, 0u);
  ASSERT_EQ(result->summary.warnings.size(), 1u);
  const EstimateWarning& warning = result->summary.warnings[0];
  EXPECT_EQ(warning.code, "OPPOSED_NORMALS");
  EXPECT_EQ(warning.points, opposed);
  EXPECT_EQ(warning.pairs, 12'000u);
  EXPECT_GT(warning.opposed_pairs, 0u);
  EXPECT_EQ(warning.flipped_patches, 1u);
  EXPECT_THAT(warning.message, ::testing::HasSubstr("make all normals point to one side"));

  EstimateOptions reject;
  reject.reject_opposed_normals = true;
  const absl::Status refused = client->Estimate(cloud, reject).status();
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_EQ(ErrorReason(refused), "OPPOSED_NORMALS");
}

TEST(CurvatureClientTest, EstimatesASphere) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(5000);
  const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->mean.size(), 5000u);
  EXPECT_EQ(result->summary.status_counts[1], 5000u);
  // Neighborhoods of 50 of 5000 points have a radius of 0.2: the mean over them differs from 1 by a share of its
  // square.
  for (const float mean : result->mean) EXPECT_NEAR(mean, 1.0f, 0.03f);
}

TEST(CurvatureClientTest, DoublesFloatsChannelsAndChunksAgree) {
  const auto server = StartServer();
  const SphereCloud cloud = Sphere(2000);
  const std::vector<double> doubles(cloud.points.begin(), cloud.points.end());
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const CurvatureClient in_process(server->InProcessChannel());
  const CurvatureResult expected = *client->Estimate(cloud.view(), {});
  EXPECT_EQ(in_process.Estimate(cloud.view(), {})->d1, expected.d1);
  EstimateOptions small_chunks;
  small_chunks.chunk_bytes = 1;
  EXPECT_EQ(client->Estimate(cloud.view(), small_chunks)->mean, expected.mean);
  const CurvatureResult exact = *client->Estimate(CloudView(doubles, doubles), {});
  // The same numbers, but relative to another origin: they are rounded to float anew.
  for (size_t i = 0; i < exact.mean.size(); ++i) EXPECT_NEAR(exact.mean[i], expected.mean[i], 1e-3f);
}

TEST(CurvatureClientTest, KeepsToTheServersChunkLimit) {
  curvd::ServerOptions options;
  options.max_chunk_bytes = 1024;
  const auto server = StartServer(options);
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  EXPECT_TRUE(client->Estimate(Sphere(1000).view(), {}).ok());
}

TEST(CurvatureClientTest, EmptyCloudsHaveEmptyResults) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  const absl::StatusOr<CurvatureResult> result = client.Estimate(Sphere(1).view(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status[0], static_cast<uint8_t>(PointStatus::kTooFewNeighbors));
  const absl::StatusOr<CurvatureResult> none = client.Estimate(CloudView(std::span<const float>(), {}), {});
  ASSERT_TRUE(none.ok()) << none.status();
  EXPECT_TRUE(none->mean.empty());
}

TEST(CurvatureClientTest, RefusesArraysThatDoNotMatch) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  const std::vector<float> four(4), three(3), six(6);
  EXPECT_THAT(client.Estimate(CloudView(four, four), {}).status().message(), HasSubstr("positions hold 4 scalars"));
  EXPECT_THAT(client.Estimate(CloudView(six, three), {}).status().message(), HasSubstr("normals 3"));
}

TEST(CurvatureClientTest, GivesTheQuantitiesThatWereAskedForAndNoOthers) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  const SphereCloud cloud = Sphere(20'000);
  const CurvatureResult all = *client.Estimate(cloud.view(), {});
  EstimateOptions options;
  options.quantities = {"principal_directions", "gaussian_curvature"};
  const absl::StatusOr<CurvatureResult> some = client.Estimate(cloud.view(), options);
  ASSERT_TRUE(some.ok()) << some.status();
  EXPECT_EQ(some->gaussian, all.gaussian);
  EXPECT_EQ(some->d1, all.d1);
  EXPECT_EQ(some->d2, all.d2);
  EXPECT_EQ(some->status, all.status);
  EXPECT_TRUE(some->mean.empty() && some->k1.empty() && some->k2.empty() && some->radius.empty());
}

TEST(CurvatureClientTest, RefusesQuantitiesThatItDoesNotKnow) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  EstimateOptions options;
  options.quantities = {"curl"};
  absl::Status status = client.Estimate(Sphere(10).view(), options).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(status.message(), testing::AllOf(HasSubstr("curl"), HasSubstr("principal_curvatures")));
  options.quantities = {"radius", "radius"};
  status = client.Estimate(Sphere(10).view(), options).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(status.message(), HasSubstr("twice"));
}

TEST(CurvatureClientTest, PassesTheServersErrorsOn) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  SphereCloud cloud = Sphere(100);
  cloud.points[30] = NAN;
  const absl::Status status = client.Estimate(cloud.view(), {}).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(status.message(), HasSubstr("10"));
  EXPECT_NE(ErrorReason(status), "");
  EstimateOptions skip;
  skip.skip_invalid = true;
  const absl::StatusOr<CurvatureResult> result = client.Estimate(cloud.view(), skip);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status[10], static_cast<uint8_t>(PointStatus::kInvalidInput));
}

TEST(CurvatureClientTest, ReportsProgressToTheEnd) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  EstimateProgress last;
  const SphereCloud cloud = Sphere(50'000);
  EstimateCallbacks callbacks;
  callbacks.on_progress = [&](const EstimateProgress& progress) {
    EXPECT_GE(progress.points_sent, last.points_sent);
    EXPECT_GE(progress.phase, last.phase);
    last = progress;
  };
  ASSERT_TRUE(client.Estimate(cloud.view(), {}, callbacks).ok());
  EXPECT_EQ(last.points_sent, 50'000u);
  EXPECT_EQ(last.points_received, 50'000u);
}

TEST(CurvatureClientTest, StopsWhenAsked) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  std::stop_source stop;
  EstimateCallbacks callbacks{.on_progress = [&](const EstimateProgress&) { stop.request_stop(); },
                              .stop = stop.get_token()};
  EXPECT_TRUE(absl::IsCancelled(client.Estimate(Sphere(20'000).view(), {}, callbacks).status()));
}

TEST(CurvatureClientTest, TellsAboutTheServer) {
  const auto server = StartServer();
  const absl::StatusOr<ServerInfo> info =
      (*CurvatureClient::Connect(AddressOf(server->port())))->GetServerInfo(absl::Seconds(10));
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->health, "SERVING");
  EXPECT_EQ(info->worker_threads, 2u);
  EXPECT_THAT(info->estimators, ::testing::Contains("avg-hexagram"));
  EXPECT_GT(info->max_points, 0u);
}

TEST(CurvatureClientTest, TakesServersWithoutAPort) {
  for (const char* servers :
       {"localhost", "curvd.example, 10.0.0.1", "::1", "[::1]", "dns:///curvd.example", "dns:a"}) {
    EXPECT_TRUE(CurvatureClient::Connect(servers).ok()) << servers;
  }
}

TEST(CurvatureClientTest, RefusesBadServerLists) {
  for (const char* servers : {"", "a:1,", "a:1,,b:2", ":50061", "host:", "dns:", "dns:///"}) {
    EXPECT_THAT(CurvatureClient::Connect(servers).status().message(), HasSubstr("is neither HOST nor HOST:PORT"))
        << servers;
  }
}

TEST(CurvatureClientTest, RefusesUrlsOfTheWeb) {
  for (const char* servers :
       {"http://a", "a:1,https://b:2", "HTTPS://a/", "grpc://a:1", "tcp://a:1", "DNS:///a", "foo+x.y-z:///x"}) {
    EXPECT_THAT(CurvatureClient::Connect(servers).status().message(), HasSubstr("is a URL; it must be HOST"))
        << servers;
  }
  EXPECT_THAT(CurvatureClient::Connect("https://b:2").status().message(),
              HasSubstr("without https://: TLS has an option of its own"));
  EXPECT_THAT(std::string(CurvatureClient::Connect("http://b:2").status().message()),
              ::testing::EndsWith("without http://"));
}

// gRPC calls port 99999 34463.
TEST(CurvatureClientTest, RefusesPortsThatThereAreNot) {
  for (const char* servers : {"a:0", "a:65536", "a:99999", "a:http", "a:1,b:-1", "[::1]:1e3", "dns:///a:99999"}) {
    EXPECT_THAT(std::string(CurvatureClient::Connect(servers).status().message()), HasSubstr("must be from 1 to 65535"))
        << servers;
  }
  for (const char* servers : {"a:1", "a:65535", "unix:/run/curvd.sock", "ipv4:127.0.0.1:50061", "[::1]:50061"}) {
    EXPECT_TRUE(CurvatureClient::Connect(servers).ok()) << servers;
  }
}

}  // namespace
}  // namespace curv
