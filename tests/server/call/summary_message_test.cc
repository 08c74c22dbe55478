#include "server/call/summary_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(FillSummaryTest, TellsWhatTheRecordHolds) {
  CallRecord record;
  record.points_received = 36;
  record.status_counts = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  record.normals_rescaled = 6;
  record.peak_bytes = 7;
  record.seconds = {0.1, 0.2, 0.3, 0.4, 0.7, 0.8, 0.5, 0.6};
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  EXPECT_EQ(summary.point_count(), 36u);
  EXPECT_EQ(summary.status_counts().ok(), 1u);
  EXPECT_EQ(summary.status_counts().too_few_neighbors(), 2u);
  EXPECT_EQ(summary.status_counts().degenerate_area(), 3u);
  EXPECT_EQ(summary.status_counts().invalid_input(), 4u);
  EXPECT_EQ(summary.status_counts().inconsistent_normals(), 5u);
  EXPECT_EQ(summary.status_counts().singular_fit(), 6u);
  EXPECT_EQ(summary.status_counts().opposed_normals(), 7u);
  EXPECT_EQ(summary.status_counts().outlier(), 8u);
  EXPECT_EQ(summary.normals_rescaled(), 6u);
  EXPECT_EQ(summary.peak_bytes(), 7u);
  EXPECT_EQ(summary.seconds().receive(), 0.1);
  EXPECT_EQ(summary.seconds().queue(), 0.3);
  EXPECT_EQ(summary.seconds().index(), 0.4);
  EXPECT_EQ(summary.seconds().normals(), 0.7);
  EXPECT_EQ(summary.seconds().orientation(), 0.8);
  EXPECT_EQ(summary.seconds().estimate(), 0.5);
  EXPECT_EQ(summary.seconds().send(), 0.6);
  ASSERT_EQ(summary.warnings_size(), 1);
  EXPECT_EQ(summary.warnings(0).code(), curvature::v1::WARNING_CODE_OUTLIERS);
  EXPECT_FALSE(summary.has_normals());
  EXPECT_FALSE(summary.has_scale());
}

TEST(FillSummaryTest, CountsEveryStatusOfTheContractUnderItsWord) {
  ASSERT_EQ(curvature::v1::PointStatus_ARRAYSIZE, kPointStatusEnd);
  const google::protobuf::Descriptor* counts = curvature::v1::StatusCounts::descriptor();
  ASSERT_EQ(counts->field_count(), kPointStatusEnd - 1);
  for (int value = 1; value < kPointStatusEnd; ++value) {
    const std::string word = PointStatusName(static_cast<PointStatus>(value));
    EXPECT_EQ(curvature::v1::PointStatus_Name(static_cast<curvature::v1::PointStatus>(value)),
              absl::StrCat("POINT_STATUS_", absl::AsciiStrToUpper(word)));
    ASSERT_NE(counts->FindFieldByName(word), nullptr) << word;
    EXPECT_EQ(counts->FindFieldByName(word)->number(), value);
  }
}

TEST(FillSummaryTest, TellsWhatAnAutomaticEstimateHasChosen) {
  CallRecord record;
  record.scale_report.emplace().outcomes = {{"jet", 4, 64, 0.3, 0.2, 0.1, 1.0}};
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_TRUE(summary.has_scale());
  ASSERT_EQ(summary.scale().outcomes_size(), 1);
  EXPECT_EQ(summary.scale().outcomes(0).estimator(), curvature::v1::ESTIMATOR_JET_FITTING);
}

TEST(FillSummaryTest, WarnsOfNormalsThatContradictEachOther) {
  CallRecord record;
  record.points_received = 2000;
  record.status_counts[static_cast<size_t>(PointStatus::kOpposedNormals)] = 700;
  record.agreement = {.seam_points = 300, .near_pairs = 12'000, .opposed_pairs = 750, .flipped_patches = 4};
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_EQ(summary.warnings_size(), 1);
  const curvature::v1::Warning& warning = summary.warnings(0);
  EXPECT_EQ(warning.code(), curvature::v1::WARNING_CODE_OPPOSED_NORMALS);
  EXPECT_EQ(warning.point_count(), 700u);
  EXPECT_EQ(warning.pair_count(), 12'000u);
  EXPECT_EQ(warning.opposed_pair_count(), 750u);
  EXPECT_EQ(warning.flipped_patch_count(), 4u);
  EXPECT_THAT(warning.message(),
              AllOf(HasSubstr("around 700 of 2,000 points"), HasSubstr("6.2 % of the pairs"),
                    HasSubstr("4 patches flipped"), HasSubstr("make all normals point to one side")));

  record.points_received = 1'000'000;
  record.agreement.flipped_patches = 1;
  curvature::v1::Summary of_one_patch;
  FillSummary(record, &of_one_patch);
  EXPECT_THAT(of_one_patch.warnings(0).message(),
              AllOf(HasSubstr("of 1,000,000 points"), HasSubstr("1 patch flipped")));
  record.agreement.flipped_patches = 0;
  curvature::v1::Summary of_none;
  FillSummary(record, &of_none);
  EXPECT_THAT(of_none.warnings(0).message(), AllOf(HasSubstr("0 patches flipped"), HasSubstr("has a crease")));

  record.normal_report.emplace().piece_count = 1;
  curvature::v1::Summary of_oriented;
  FillSummary(record, &of_oriented);
  EXPECT_THAT(of_oriented.warnings(0).message(), HasSubstr("have them estimated"));

  record.normal_report->method = NormalMethod::kJet2;
  curvature::v1::Summary of_estimated;
  FillSummary(record, &of_estimated);
  EXPECT_THAT(of_estimated.warnings(0).message(), HasSubstr("their normals need more neighbors"));

  record.normal_report->piece_count = 0;
  curvature::v1::Summary of_directed;
  FillSummary(record, &of_directed);
  EXPECT_THAT(of_directed.warnings(0).message(), HasSubstr("orient them consistently"));
}

TEST(FillSummaryTest, WarnsOfPositionsThatAreRoundedTooCoarsely) {
  CallRecord record;
  record.coarse_positions = {.farthest = 5e6, .step = 0.5, .spacing = 0.02};
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_EQ(summary.warnings_size(), 1);
  EXPECT_EQ(summary.warnings(0).code(), curvature::v1::WARNING_CODE_COARSE_POSITIONS);
  EXPECT_EQ(summary.warnings(0).point_count(), 0u);
  EXPECT_THAT(summary.warnings(0).message(),
              AllOf(HasSubstr("floats near 5e+06, which lie 0.5 apart there, and the points about 0.02"),
                    HasSubstr("Send doubles, or subtract an origin")));
}

TEST(FillSummaryTest, WarnsOfNormalsThatDoNotFitThePositions) {
  CallRecord record;
  record.off_surface = {.sampled_points = 128, .off_points = 30};
  curvature::v1::Summary fits;
  FillSummary(record, &fits);
  EXPECT_EQ(fits.warnings_size(), 0);
  record.off_surface->off_points = 64;
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_EQ(summary.warnings_size(), 1);
  EXPECT_EQ(summary.warnings(0).code(), curvature::v1::WARNING_CODE_NORMALS_OFF_SURFACE);
  EXPECT_THAT(summary.warnings(0).message(),
              AllOf(HasSubstr("at 50 % of 128 points that were looked at"), HasSubstr("have the normals estimated")));
}

TEST(FillSummaryTest, WarnsOfOutliers) {
  CallRecord record;
  record.points_received = 20'000;
  record.status_counts[static_cast<size_t>(PointStatus::kOk)] = 19'963;
  record.status_counts[static_cast<size_t>(PointStatus::kOutlier)] = 37;
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_EQ(summary.warnings_size(), 1);
  EXPECT_EQ(summary.warnings(0).code(), curvature::v1::WARNING_CODE_OUTLIERS);
  EXPECT_EQ(summary.warnings(0).point_count(), 37u);
  EXPECT_EQ(summary.warnings(0).pair_count(), 0u);
  EXPECT_THAT(summary.warnings(0).message(),
              AllOf(HasSubstr("37 of 20,000 points lie off the surface around them"),
                    HasSubstr("if they belong to the surface, choose the number of neighbors yourself")));

  record.status_counts[static_cast<size_t>(PointStatus::kOutlier)] = 1;
  curvature::v1::Summary of_one;
  FillSummary(record, &of_one);
  EXPECT_THAT(of_one.warnings(0).message(), HasSubstr("1 of 20,000 points lies off the surface around it"));
}

TEST(FillSummaryTest, WarnsWhereNoPointHasAResult) {
  const auto warnings = [](PointStatus status, std::optional<uint32_t> neighbors, uint64_t ok = 0) {
    CallRecord record;
    record.points_received = 30 + ok;
    record.status_counts[static_cast<size_t>(PointStatus::kOk)] = ok;
    record.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)] = 10;
    record.status_counts[static_cast<size_t>(status)] += 20;
    record.least_neighbor_count = neighbors;
    curvature::v1::Summary summary;
    FillSummary(record, &summary);
    return summary;
  };
  const curvature::v1::Summary counted = warnings(PointStatus::kTooFewNeighbors, 50);
  ASSERT_EQ(counted.warnings_size(), 1);
  EXPECT_EQ(counted.warnings(0).code(), curvature::v1::WARNING_CODE_NO_RESULTS);
  EXPECT_EQ(counted.warnings(0).message(),
            "no point has a result; most are too_few_neighbors: neighborhoods of 50 points or more were asked for, and "
            "the cloud has 30: send more points, or ask for fewer neighbors");
  EXPECT_THAT(warnings(PointStatus::kTooFewNeighbors, {}).warnings(0).message(), HasSubstr("a larger radius"));
  EXPECT_THAT(warnings(PointStatus::kTooFewNeighbors, 30).warnings(0).message(), HasSubstr("a larger radius"));
  EXPECT_THAT(warnings(PointStatus::kDegenerateArea, 20).warnings(0).message(), HasSubstr("have no area"));
  EXPECT_THAT(warnings(PointStatus::kInconsistentNormals, 20).warnings(0).message(), HasSubstr("normals cancel out"));
  EXPECT_THAT(warnings(PointStatus::kSingularFit, 20).warnings(0).message(), HasSubstr("most are singular_fit: "));
  EXPECT_THAT(warnings(PointStatus::kInvalidInput, 20).warnings(0).message(),
              HasSubstr("most are invalid_input: their"));
  EXPECT_EQ(warnings(PointStatus::kTooFewNeighbors, 50, 1).warnings_size(), 0);
  EXPECT_EQ(warnings(PointStatus::kOpposedNormals, 50).warnings_size(), 0);
  const curvature::v1::Summary of_outliers = warnings(PointStatus::kOutlier, {});
  ASSERT_EQ(of_outliers.warnings_size(), 1);
  EXPECT_EQ(of_outliers.warnings(0).code(), curvature::v1::WARNING_CODE_OUTLIERS);
}

TEST(FillSummaryTest, NamesAllThatMayMakePointsUnusable) {
  const auto warning = [](const PointInput& input) {
    CallRecord record;
    record.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)] = 10;
    record.point_input = input;
    curvature::v1::Summary summary;
    FillSummary(record, &summary);
    return summary.warnings_size() == 1 ? summary.warnings(0).message() : "";
  };
  EXPECT_THAT(warning({}), HasSubstr("their positions are not finite, or their normals have no direction"));
  EXPECT_THAT(warning({.has_lattice = true}), HasSubstr("farther than 2^23 times lattice.spacing from lattice.origin"));
  EXPECT_THAT(warning({.has_doubles = true}), HasSubstr("farther than 3e38"));
  EXPECT_THAT(warning({.has_viewpoints = true}), HasSubstr("viewpoints"));
  EXPECT_THAT(warning({.has_normals = false}), Not(HasSubstr("normals")));
}

TEST(FillSummaryTest, CurvatureBeyondTheFloatsIsNoLine) {
  CallRecord record;
  record.status_counts[static_cast<size_t>(PointStatus::kDegenerateArea)] = 10;
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  ASSERT_EQ(summary.warnings_size(), 1);
  EXPECT_THAT(summary.warnings(0).message(), HasSubstr("curvature is beyond 3e38"));
}

TEST(FillSummaryTest, WarnsOfSidesThatCannotBeTrusted) {
  CallRecord record;
  record.normal_report.emplace();
  record.normal_report->certificate = kMaxTrustedCertificate;
  curvature::v1::Summary trusted;
  FillSummary(record, &trusted);
  EXPECT_EQ(trusted.warnings_size(), 0);
  EXPECT_FALSE(trusted.normals().doubtful());

  record.normal_report->certificate = 0.98;
  curvature::v1::Summary doubtful;
  FillSummary(record, &doubtful);
  EXPECT_TRUE(doubtful.normals().doubtful());
  ASSERT_EQ(doubtful.warnings_size(), 1);
  EXPECT_EQ(doubtful.warnings(0).code(), curvature::v1::WARNING_CODE_DOUBTFUL_ORIENTATION);
  EXPECT_THAT(doubtful.warnings(0).message(), AllOf(HasSubstr("certificate is 0.98"), HasSubstr("at most 0.25")));

  // Noise explains a certificate if the sides stay at another scale, but nothing explains sides that turn.
  record.normal_report->turned_share = 0.0;
  record.normal_report->turned_share_decides = true;
  curvature::v1::Summary settled;
  FillSummary(record, &settled);
  EXPECT_EQ(settled.warnings_size(), 0);
  record.normal_report->certificate.reset();
  record.normal_report->turned_share = 0.034;
  curvature::v1::Summary turned;
  FillSummary(record, &turned);
  EXPECT_TRUE(turned.normals().doubtful());
  ASSERT_EQ(turned.warnings_size(), 1);
  EXPECT_THAT(turned.warnings(0).message(), HasSubstr("3.4 % of them point to the other side"));
  record.normal_report->turned_share = 0.0;
  record.normal_report->ambiguous_piece_count = 3;
  curvature::v1::Summary nested;
  FillSummary(record, &nested);
  EXPECT_TRUE(nested.normals().doubtful());
  ASSERT_EQ(nested.warnings_size(), 1);
  EXPECT_THAT(nested.warnings(0).message(), HasSubstr("3 closed pieces lie within others"));
}

TEST(FillSummaryTest, SaysWhySidesCannotBeTrustedWithoutACertificate) {
  const auto message_of = [](auto set) {
    CallRecord record;
    set(record.normal_report.emplace());
    curvature::v1::Summary summary;
    FillSummary(record, &summary);
    EXPECT_TRUE(summary.normals().doubtful());
    return summary.warnings_size() == 1 ? summary.warnings(0).message() : "";
  };
  EXPECT_THAT(message_of([](NormalReport& report) {
                report.mixes_sides = true;
                report.opposed_share = 0.46;
              }),
              HasSubstr("46 % of the neighbors of which they were made"));
  EXPECT_THAT(message_of([](NormalReport& report) { report.torn_share = 0.031; }),
              HasSubstr("those of 3.1 % of the neighbors on one sheet are opposed"));
  EXPECT_THAT(message_of([](NormalReport& report) { report.may_be_closed = true; }),
              HasSubstr("may be the two sides of a thin body"));
  EXPECT_THAT(message_of([](NormalReport& report) {
                report.turned_share = 0.007;
                report.most_turned_share = kMostTurnedShareOfThin;
              }),
              HasSubstr("0.7 % of them point to the other side"));
}

}  // namespace
}  // namespace curvd
