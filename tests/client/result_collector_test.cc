#include "client/result_collector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "tests/byte_buffers.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
using ::testing::HasSubstr;

v1::EstimateCurvatureResponse Accepted() {
  v1::EstimateCurvatureResponse response;
  response.mutable_accepted()->set_request_id("r-7");
  response.mutable_accepted()->mutable_limits()->set_max_chunk_bytes(4096);
  return response;
}

v1::EstimateCurvatureResponse Result(uint64_t first, uint32_t count, char status = 1) {
  v1::EstimateCurvatureResponse response;
  v1::ResultChunk& chunk = *response.mutable_result();
  chunk.set_first_index(first);
  chunk.set_point_count(count);
  chunk.set_status(std::string(count, status));
  for (std::string* scalars : {chunk.mutable_mean_curvature(), chunk.mutable_gaussian_curvature(), chunk.mutable_k1(),
                               chunk.mutable_k2(), chunk.mutable_radius()}) {
    const std::vector<float> values(count, static_cast<float>(first));
    scalars->assign(reinterpret_cast<const char*>(values.data()), 4 * count);
  }
  chunk.set_d1(std::string(12 * count, '\0'));
  chunk.set_d2(std::string(12 * count, '\0'));
  return response;
}

v1::EstimateCurvatureResponse Summary(uint64_t points, uint64_t ok) {
  v1::EstimateCurvatureResponse response;
  response.mutable_summary()->set_point_count(points);
  response.mutable_summary()->mutable_status_counts()->set_ok(ok);
  response.mutable_summary()->mutable_status_counts()->set_degenerate_area(points - ok);
  return response;
}

constexpr size_t kPieceBytes = 7;  // no float lies in a piece of its own

// Feeds messages until one is refused.
absl::Status Feed(ResultCollector& collector, const std::vector<v1::EstimateCurvatureResponse>& responses) {
  for (const auto& response : responses) {
    grpc::ByteBuffer message = curvd::ToByteBuffer(response.SerializeAsString(), kPieceBytes);
    if (absl::Status status = collector.Take(message); !status.ok()) return status;
  }
  return collector.Finish();
}

std::string Problem(uint64_t points, const std::vector<v1::EstimateCurvatureResponse>& responses) {
  ResultCollector collector(points);
  const absl::Status status = Feed(collector, responses);
  EXPECT_TRUE(absl::IsInternal(status)) << status;
  return std::string(status.message());
}

TEST(ResultCollectorTest, CollectsChunks) {
  ResultCollector collector(5);
  const absl::Status status = Feed(collector, {Accepted(), Result(0, 2), Result(2, 3, 3), Summary(5, 2)});
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(collector.limits().max_chunk_bytes(), 4096u);
  const CurvatureResult result = collector.Release();
  EXPECT_EQ(result.mean, (std::vector<float>{0, 0, 2, 2, 2}));
  EXPECT_EQ(result.status, (std::vector<uint8_t>{1, 1, 3, 3, 3}));
  EXPECT_EQ(result.d1.size(), 15u);
  EXPECT_EQ(result.summary.request_id, "r-7");
  EXPECT_EQ(result.summary.status_counts[3], 3u);
}

TEST(ResultCollectorTest, KnowsEveryStatusOfTheContractByItsWord) {
  ASSERT_EQ(v1::PointStatus_ARRAYSIZE, static_cast<int>(kStatusWords.size()));
  const google::protobuf::Descriptor* counts = v1::StatusCounts::descriptor();
  for (int value = 1; value < v1::PointStatus_ARRAYSIZE; ++value) {
    const std::string word(kStatusWords[static_cast<size_t>(value)]);
    EXPECT_EQ(v1::PointStatus_Name(static_cast<v1::PointStatus>(value)),
              absl::StrCat("POINT_STATUS_", absl::AsciiStrToUpper(word)));
    v1::EstimateCurvatureResponse summary = Summary(3, 3);
    v1::StatusCounts& of_all = *summary.mutable_summary()->mutable_status_counts();
    of_all.Clear();
    of_all.GetReflection()->SetUInt64(&of_all, counts->FindFieldByName(word), 3);
    ResultCollector collector(3);
    const absl::Status status = Feed(collector, {Accepted(), Result(0, 3, static_cast<char>(value)), summary});
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_EQ(collector.Release().summary.status_counts[static_cast<size_t>(value)], 3u) << word;
  }
}

v1::EstimateCurvatureResponse AcceptedCounts(std::initializer_list<uint32_t> counts) {
  v1::EstimateCurvatureResponse response = Accepted();
  for (const uint32_t count : counts) response.mutable_accepted()->mutable_options()->add_neighbor_counts(count);
  return response;
}

v1::EstimateCurvatureResponse ScaleResult(uint64_t first, uint32_t points, uint32_t neighbors, char status = 1) {
  v1::EstimateCurvatureResponse response = Result(first, points, status);
  response.mutable_result()->set_neighbor_count(neighbors);
  return response;
}

EstimateOptions CountOptions() {
  EstimateOptions options;
  options.neighbor_counts = {16, 64};
  return options;
}

v1::EstimateCurvatureResponse TwoScaleSummary(uint64_t points, uint64_t ok) {
  v1::EstimateCurvatureResponse response = Summary(2 * points, ok);
  response.mutable_summary()->set_point_count(points);
  return response;
}

TEST(ResultCollectorTest, CollectsSeveralScales) {
  ResultCollector collector(5, CountOptions());
  const absl::Status status = Feed(collector, {AcceptedCounts({16, 64}), ScaleResult(0, 2, 16),
                                               ScaleResult(2, 3, 16, 3), ScaleResult(0, 5, 64), TwoScaleSummary(5, 7)});
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(collector.points_received(), 5u);
  const CurvatureResult result = collector.Release();
  EXPECT_TRUE(result.mean.empty() && result.status.empty());
  ASSERT_EQ(result.scales.size(), 2u);
  EXPECT_EQ(result.scales[0].neighbor_count, 16u);
  EXPECT_EQ(result.scales[0].mean, (std::vector<float>{0, 0, 2, 2, 2}));
  EXPECT_EQ(result.scales[0].status, (std::vector<uint8_t>{1, 1, 3, 3, 3}));
  EXPECT_EQ(result.scales[1].neighbor_count, 64u);
  EXPECT_EQ(result.scales[1].status, (std::vector<uint8_t>(5, 1)));
  EXPECT_EQ(result.summary.status_counts[1], 7u);
}

TEST(ResultCollectorTest, LetsNoScaleBeMissingOrAnotherOne) {
  const auto problem = [](const std::vector<v1::EstimateCurvatureResponse>& responses) {
    ResultCollector collector(2, CountOptions());
    return std::string(Feed(collector, responses).message());
  };
  EXPECT_THAT(problem({Accepted()}), HasSubstr("too old to take several neighbor counts"));
  EXPECT_THAT(problem({AcceptedCounts({16})}), HasSubstr("too old to take several neighbor counts"));
  const auto accepted = AcceptedCounts({16, 64});
  EXPECT_THAT(problem({accepted, ScaleResult(0, 2, 64)}), HasSubstr("is of 64 neighbors, not of 16"));
  EXPECT_THAT(problem({accepted, Result(0, 2)}), HasSubstr("is of 0 neighbors, not of 16"));
  EXPECT_THAT(problem({accepted, ScaleResult(0, 1, 16), ScaleResult(0, 2, 64)}),
              HasSubstr("is of 64 neighbors, not of 16"));
  EXPECT_THAT(problem({accepted, ScaleResult(0, 2, 16), TwoScaleSummary(2, 4)}), HasSubstr("without results of 64"));
  EXPECT_THAT(problem({accepted, ScaleResult(0, 2, 16), ScaleResult(0, 1, 64), TwoScaleSummary(2, 4)}),
              HasSubstr("1 of 2 results came"));
  EXPECT_THAT(problem({accepted, ScaleResult(0, 2, 16), ScaleResult(0, 2, 64), ScaleResult(0, 2, 64)}),
              HasSubstr("2 of 2 are here"));
  EXPECT_THAT(problem({accepted, ScaleResult(0, 2, 16), ScaleResult(0, 2, 64), TwoScaleSummary(2, 3)}),
              HasSubstr("status counts are not those"));
}

TEST(ResultCollectorTest, TakesResultsAsNobodyWritesThem) {
  ResultCollector collector(3);
  grpc::ByteBuffer accepted = curvd::ToByteBuffer(Accepted().SerializeAsString());
  ASSERT_TRUE(collector.Take(accepted).ok());
  // The same field twice: protobuf takes the last.
  v1::EstimateCurvatureResponse first_only;
  first_only.mutable_result()->set_point_count(7);
  grpc::ByteBuffer twice = curvd::ToByteBuffer(first_only.SerializeAsString() + Result(0, 3).SerializeAsString());
  const absl::Status status = collector.Take(twice);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(collector.points_received(), 3u);
}

TEST(ResultCollectorTest, RefusesBytesThatAreNoMessage) {
  for (const bool is_accepted : {false, true}) {
    ResultCollector collector(1);
    if (is_accepted) {
      grpc::ByteBuffer accepted = curvd::ToByteBuffer(Accepted().SerializeAsString());
      EXPECT_TRUE(collector.Take(accepted).ok());
    }
    grpc::ByteBuffer message = curvd::ToByteBuffer("\x0f\xff");
    const absl::Status status = collector.Take(message);
    EXPECT_TRUE(absl::IsInternal(status));
    EXPECT_THAT(std::string(status.message()), HasSubstr("cannot be parsed"));
  }
}

TEST(ResultCollectorTest, TakesAnEmptyCloud) {
  ResultCollector collector(0);
  EXPECT_TRUE(Feed(collector, {Accepted(), Summary(0, 0)}).ok());
}

TEST(ResultCollectorTest, TakesProgressAndWhatItDoesNotKnow) {
  ResultCollector collector(1);
  v1::EstimateCurvatureResponse progress;
  progress.mutable_progress()->set_points_estimated(1);
  EXPECT_TRUE(
      Feed(collector, {Accepted(), progress, v1::EstimateCurvatureResponse(), Result(0, 1), Summary(1, 1)}).ok());
  EXPECT_EQ(collector.progress().points_estimated(), 1u);
}

TEST(ResultCollectorTest, RefusesGapsAndRepeats) {
  EXPECT_THAT(Problem(5, {Accepted(), Result(0, 2), Result(3, 2)}), HasSubstr("from index 3, but 2 of 5"));
  EXPECT_THAT(Problem(5, {Accepted(), Result(0, 2), Result(0, 2)}), HasSubstr("from index 0"));
  EXPECT_THAT(Problem(5, {Accepted(), Result(0, 6)}), HasSubstr("6 points"));
  EXPECT_THAT(Problem(5, {Accepted(), Result(0, 0)}), HasSubstr("0 points"));
}

TEST(ResultCollectorTest, RefusesWrongOrder) {
  EXPECT_THAT(Problem(1, {Result(0, 1)}), HasSubstr("not Accepted"));
  EXPECT_THAT(Problem(1, {Accepted(), Accepted()}), HasSubstr("twice"));
  EXPECT_THAT(Problem(1, {Accepted(), Result(0, 1), Summary(1, 1), Result(0, 1)}), HasSubstr("follows the summary"));
}

TEST(ResultCollectorTest, RefusesWhatIsNotWhole) {
  EXPECT_THAT(Problem(1, {}), HasSubstr("before it was accepted"));
  EXPECT_THAT(Problem(2, {Accepted(), Result(0, 1)}), HasSubstr("without a summary, after 1 of 2"));
  EXPECT_THAT(Problem(2, {Accepted(), Result(0, 1), Summary(2, 2)}), HasSubstr("1 of 2 results"));
  EXPECT_THAT(Problem(2, {Accepted(), Result(0, 2), Summary(1, 1)}), HasSubstr("counts 1 points"));
  EXPECT_THAT(Problem(2, {Accepted(), Result(0, 2), Summary(2, 1)}), HasSubstr("status counts"));
  EXPECT_THAT(Problem(2, {Accepted(), Result(0, 2, 77), Summary(2, 2)}), HasSubstr("status counts"));
}

EstimateOptions AskingForAScale() {
  EstimateOptions options;
  options.automatic_scale.emplace();
  return options;
}

TEST(ResultCollectorTest, AServerThatChoosesNoScaleIsTooOld) {
  ResultCollector collector(1, AskingForAScale());
  const absl::Status status = Feed(collector, {Accepted(), Result(0, 1), Summary(1, 1)});
  EXPECT_TRUE(absl::IsUnimplemented(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("too old to choose a scale"));
}

TEST(ResultCollectorTest, TellsWhatTheServerChose) {
  v1::EstimateCurvatureResponse accepted = Accepted(), summary = Summary(1, 1);
  accepted.mutable_accepted()->mutable_options()->mutable_automatic_scale();
  v1::ScaleReport& scale = *summary.mutable_summary()->mutable_scale();
  scale.set_sampled_point_count(512);
  scale.set_position_noise(0.01);
  v1::ScaleOutcome& outcome = *scale.add_outcomes();
  outcome.set_estimator(v1::ESTIMATOR_JET_FITTING);
  outcome.set_degree(4);
  outcome.set_neighbor_count(64);
  outcome.set_error(0.4);
  outcome.set_noise(0.3);
  outcome.set_bias(0.2);
  outcome.set_share(1.0);
  scale.add_outcomes()->set_estimator(static_cast<v1::Estimator>(99));  // which the contract gains later
  ResultCollector collector(1, AskingForAScale());
  const absl::Status status = Feed(collector, {accepted, Result(0, 1), summary});
  ASSERT_TRUE(status.ok()) << status;
  const CurvatureResult result = collector.Release();
  ASSERT_TRUE(result.summary.scale.has_value());
  const ScaleReport& report = *result.summary.scale;
  EXPECT_EQ(report.sampled_points, 512u);
  EXPECT_EQ(report.position_noise, 0.01);
  ASSERT_EQ(report.outcomes.size(), 2u);
  EXPECT_EQ(report.outcomes[0].estimator, "jet");
  EXPECT_EQ(report.outcomes[0].degree, 4u);
  EXPECT_EQ(report.outcomes[0].neighbor_count, 64u);
  EXPECT_EQ(report.outcomes[0].error, 0.4);
  EXPECT_EQ(report.outcomes[0].noise, 0.3);
  EXPECT_EQ(report.outcomes[0].bias, 0.2);
  EXPECT_EQ(report.outcomes[0].share, 1.0);
  EXPECT_EQ(report.outcomes[1].estimator, "99");
}

TEST(ResultCollectorTest, TellsOfNoChoiceWhereThereWasNone) {
  ResultCollector collector(1);
  ASSERT_TRUE(Feed(collector, {Accepted(), Result(0, 1), Summary(1, 1)}).ok());
  EXPECT_FALSE(collector.Release().summary.scale.has_value());
}

v1::EstimateCurvatureResponse AcceptedFor(std::initializer_list<v1::Quantity> quantities) {
  v1::EstimateCurvatureResponse response = Accepted();
  for (const v1::Quantity quantity : quantities) response.mutable_accepted()->add_quantities(quantity);
  return response;
}

v1::EstimateCurvatureResponse RadiusOf(uint32_t count) {
  v1::EstimateCurvatureResponse response;
  response.mutable_result()->set_point_count(count);
  response.mutable_result()->set_status(std::string(count, '\1'));
  response.mutable_result()->set_radius(std::string(4 * count, '\0'));
  return response;
}

EstimateOptions Asking(std::vector<std::string> quantities) {
  EstimateOptions options;
  options.quantities = std::move(quantities);
  return options;
}

TEST(ResultCollectorTest, CollectsWhatAcceptedTellsOfAndNothingElse) {
  ResultCollector collector(2, Asking({"radius"}));
  const absl::Status status = Feed(collector, {AcceptedFor({v1::QUANTITY_RADIUS}), RadiusOf(2), Summary(2, 2)});
  ASSERT_TRUE(status.ok()) << status;
  const CurvatureResult result = collector.Release();
  EXPECT_EQ(result.radius.size(), 2u);
  EXPECT_EQ(result.status.size(), 2u);
  EXPECT_TRUE(result.mean.empty() && result.k1.empty() && result.d1.empty() && result.others.empty());
}

TEST(ResultCollectorTest, RefusesQuantitiesThatAreMissingOrTooMany) {
  EXPECT_THAT(Problem(2, {AcceptedFor({v1::QUANTITY_RADIUS}), Result(0, 2)}), HasSubstr("does not tell of"));
  EXPECT_THAT(Problem(2, {AcceptedFor({v1::QUANTITY_MEAN_CURVATURE}), RadiusOf(2)}), HasSubstr("mean_curvature"));
  ResultCollector collector(2, Asking({"radius"}));
  const absl::Status status = Feed(collector, {AcceptedFor({v1::QUANTITY_MEAN_CURVATURE})});
  EXPECT_TRUE(absl::IsInternal(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("without the quantity radius"));
}

TEST(ResultCollectorTest, CollectsNormalsAndWhatWasFoundOutAboutThem) {
  EstimateOptions options = Asking({"normals", "normal_quality"});
  options.normals.source = NormalSource::kEstimate;
  ResultCollector collector(2, options);
  v1::EstimateCurvatureResponse accepted = AcceptedFor({v1::QUANTITY_NORMALS, v1::QUANTITY_NORMAL_QUALITY});
  accepted.mutable_accepted()->mutable_normals()->set_source(v1::NORMAL_SOURCE_ESTIMATE);
  v1::EstimateCurvatureResponse chunk;
  chunk.mutable_result()->set_point_count(2);
  chunk.mutable_result()->set_status(std::string(2, '\1'));
  chunk.mutable_result()->set_normal(std::string(24, '\0'));
  chunk.mutable_result()->set_normal_residual(std::string(8, '\0'));
  chunk.mutable_result()->set_normal_variance_ratio(std::string(8, '\0'));
  v1::EstimateCurvatureResponse summary = Summary(2, 2);
  v1::NormalsReport& report = *summary.mutable_summary()->mutable_normals();
  report.set_method(v1::NORMAL_METHOD_JET_4);
  report.set_neighbor_count(24);
  report.set_piece_count(3);
  report.set_certificate(0.5);
  report.set_doubtful(true);
  const absl::Status status = Feed(collector, {accepted, chunk, summary});
  ASSERT_TRUE(status.ok()) << status;
  const CurvatureResult result = collector.Release();
  EXPECT_EQ(result.normals.size(), 6u);
  EXPECT_EQ(result.normal_residual.size(), 2u);
  EXPECT_EQ(result.normal_variance_ratio.size(), 2u);
  EXPECT_TRUE(result.others.empty());
  ASSERT_TRUE(result.summary.normals.has_value());
  EXPECT_EQ(result.summary.normals->method, NormalMethod::kJet4);
  EXPECT_EQ(result.summary.normals->neighbor_count, 24u);
  EXPECT_EQ(result.summary.normals->pieces, 3u);
  EXPECT_EQ(result.summary.normals->certificate, 0.5);
  EXPECT_FALSE(result.summary.normals->noise.has_value());
  EXPECT_TRUE(result.summary.normals->doubtful);
}

TEST(ResultCollectorTest, NoticesAServerThatTakesNormalsAsGiven) {
  EstimateOptions options;
  options.normals.source = NormalSource::kOrient;
  ResultCollector collector(2, options);
  const absl::Status status = Feed(collector, {AcceptedFor({v1::QUANTITY_RADIUS})});
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented) << status;
}

TEST(ResultCollectorTest, RefusesArraysOfWrongLength) {
  const std::vector<std::function<std::string*(v1::ResultChunk&)>> arrays = {
      [](v1::ResultChunk& c) { return c.mutable_status(); },
      [](v1::ResultChunk& c) { return c.mutable_mean_curvature(); },
      [](v1::ResultChunk& c) { return c.mutable_gaussian_curvature(); },
      [](v1::ResultChunk& c) { return c.mutable_k1(); },
      [](v1::ResultChunk& c) { return c.mutable_k2(); },
      [](v1::ResultChunk& c) { return c.mutable_d1(); },
      [](v1::ResultChunk& c) { return c.mutable_d2(); },
      [](v1::ResultChunk& c) { return c.mutable_radius(); }};
  for (const auto& array : arrays) {
    for (const int change : {-1, 1}) {
      v1::EstimateCurvatureResponse response = Result(0, 2);
      std::string* bytes = array(*response.mutable_result());
      bytes->resize(bytes->size() + static_cast<size_t>(change));
      EXPECT_THAT(Problem(2, {Accepted(), response}), HasSubstr("does not hold 2 points"));
    }
  }
}

}  // namespace
}  // namespace curv
