// What the program prints: numbers, JSON, progress, flags' values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "client/cli/flags.h"
#include "client/cli/json.h"
#include "client/cli/normals/normals_text.h"
#include "client/cli/numbers.h"
#include "client/cli/progress_bar.h"
#include "client/cli/scale/scale_text.h"

namespace curv {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(NumbersTest, GroupsDigits) {
  EXPECT_EQ(WithCommas(0), "0");
  EXPECT_EQ(WithCommas(999), "999");
  EXPECT_EQ(WithCommas(1000), "1,000");
  EXPECT_EQ(WithCommas(12345678), "12,345,678");
}

TEST(NumbersTest, TellsNumbersApartThatDifferInTheLastDigit) {
  EXPECT_EQ(ExactText(0.5), "0.5");
  EXPECT_EQ(ExactText(100'000), "100000");
  EXPECT_EQ(ExactText(1.0 / 1024), "0.0009765625");
  EXPECT_EQ(ExactText(1.0000001), "1.0000001");
}

TEST(NumbersTest, TakesPrefixes) {
  EXPECT_EQ(WithPrefix(0), "0.00");
  EXPECT_EQ(WithPrefix(9.994), "9.99");
  EXPECT_EQ(WithPrefix(950), "950");
  EXPECT_EQ(WithPrefix(999.7), "1.00 k");
  EXPECT_EQ(WithPrefix(12'345'678), "12.3 M");
}

TEST(NumbersTest, TellsTime) {
  EXPECT_EQ(Clock(0.4), "0 s");
  EXPECT_EQ(Clock(59.4), "59 s");
  EXPECT_EQ(Clock(65), "1:05");
  EXPECT_EQ(Clock(3600), "1:00:00");
  EXPECT_EQ(Clock(NAN), "0 s");
  EXPECT_EQ(Clock(INFINITY), "8333:20:00");
}

TEST(JsonLineTest, KeepsOrderAndEscapes) {
  EXPECT_EQ(ToJsonLine({{"z\"\\\n", "b"}, {"a", {{"nan", NAN}, {"half", 0.5}, {"big", 18446744073709551615u}}}}),
            "{\"z\\\"\\\\\\n\":\"b\",\"a\":{\"nan\":null,\"half\":0.5,\"big\":18446744073709551615}}\n");
}

TEST(JsonLineTest, KeepsTextInAnyLanguage) {
  EXPECT_EQ(ToJsonLine({{"input", "Gesch\u00fctz \u6811.ply"}}), "{\"input\":\"Gesch\u00fctz \u6811.ply\"}\n");
}

TEST(JsonLineTest, ReplacesBytesThatAreNoText) {
  EXPECT_EQ(ToJsonLine({{"input",
                         "a\xff"
                         "b\xc3"}}),
            "{\"input\":\"a\uFFFD"
            "b\uFFFD\"}\n");
}

TEST(ProgressLineTest, ShowsShareRateAndTimeLeft) {
  EstimateProgress progress{.points = 1000, .points_sent = 1000, .points_estimated = 250};
  progress.phase = EstimateProgress::Phase::kEstimating;
  const std::string line = ProgressLine(progress, 2.0);
  EXPECT_THAT(line, HasSubstr("received 100 %"));
  EXPECT_THAT(line, HasSubstr("estimated  25 %"));
  EXPECT_THAT(line, HasSubstr("125 points/s, ETA 6 s"));
  EXPECT_THAT(line, Not(HasSubstr("attempt")));
}

TEST(ProgressLineTest, SurvivesNothingAndMore) {
  EXPECT_THAT(ProgressLine(EstimateProgress{}, 0.0), HasSubstr("100 %"));
  EstimateProgress progress{.attempt = 2, .points = 10, .points_received = 11};
  progress.phase = EstimateProgress::Phase::kReceiving;
  EXPECT_THAT(ProgressLine(progress, 1e-9), HasSubstr("(attempt 2)"));
}

TEST(ProgressLineTest, NamesThePhasesOfNormals) {
  EstimateProgress progress{.points = 10, .points_sent = 10};
  progress.phase = EstimateProgress::Phase::kMakingNormals;
  EXPECT_THAT(ProgressLine(progress, 1.0), HasSubstr("normals "));
  progress.phase = EstimateProgress::Phase::kOrienting;
  EXPECT_THAT(ProgressLine(progress, 1.0), HasSubstr("orienting "));
  progress.phase = EstimateProgress::Phase::kReceiving;
  EXPECT_THAT(ProgressLine(progress, 1.0), HasSubstr("receiving "));
}

// Sent to the half, estimated to a tenth: 0.5 * (50 + 10) % of the file, whose share is from 40 to 80 %.
TEST(BatchLineTest, OneBarShowsAllFiles) {
  EstimateProgress progress{.points = 1000, .points_sent = 500, .points_estimated = 100};
  progress.phase = EstimateProgress::Phase::kEstimating;
  const BatchShare share{.title = "2 of 3, b.ply: ", .begin = 0.4, .end = 0.8};
  EXPECT_EQ(BatchLine(share, progress), "[##########..........]  52 %, 2 of 3, b.ply: estimating  30 %");
  progress.phase = EstimateProgress::Phase::kReceiving;
  progress.points_sent = 1000;
  EXPECT_EQ(BatchLine(share, progress), "[################....]  80 %, 2 of 3, b.ply: receiving 100 %");
  EXPECT_EQ(BatchLine(share, EstimateProgress{}), "[########............]  40 %, 2 of 3, b.ply: connecting   0 %");
}

TEST(NormalsTextTest, TellsHowNormalsWereMadeAndHowFarTheyCanBeTrusted) {
  NormalsReport report{.method = NormalMethod::kJet4, .neighbor_count = 24, .pieces = 1, .closed_pieces = 1};
  EXPECT_EQ(NormalsText(report), "normals by jet-4 of 24 points; 1 piece, closed");
  report.noise = 0.00123456;
  report.certificate = 0.0042;
  report.missing = 1000;
  EXPECT_EQ(
      NormalsText(report),
      "normals by jet-4 of 24 points, noise 0.00123; 1 piece, closed, certificate 0.0042; 1,000 points have none");
  report.noisy_part = {NormalMethod::kJet2, 192, 0.0123456, 0.257};
  EXPECT_EQ(NormalsText(report),
            "normals by jet-4 of 24 points, noise 0.00123 (the noisiest 26 % by jet-2 of 192 points, noise 0.0123); "
            "1 piece, closed, certificate 0.0042; 1,000 points have none");
  EXPECT_EQ(NormalsJson(report)["noisy_part"]["neighbor_count"], 192);
  EXPECT_EQ(NormalsText({.turned = 12'345, .pieces = 3, .closed_pieces = 1, .repaired = 7}),
            "12,345 normals turned; 3 pieces, 1 closed, 7 normals repaired");
  EXPECT_EQ(NormalsText({.method = NormalMethod::kPca}), "normals by pca");
}

ScaleReport TriedScales() {
  return {{{"avg-hexagram", 0, 64, 0.3, 0.29, 0.0, 0.25},
           {"avg-hexagram", 0, 128, 0.4, 0.1, 0.35, 0.0},
           {"jet", 2, 256, 0.2, 0.15, 0.1, 0.5},
           {"jet", 4, 256, 0.25, 0.25, 0.0, 0.25},
           {"normal-regression", 3, 91, 0.9, 0.9, 0.0, 0.0},
           {"normal-regression", 3, 128, 12345.678, 0.00001234, 0.0, 0.0},
           {"normal-regression", 1, 181, 0.8, 0.8, 0.0, 0.0}},
          512,
          0.0123456};
}

TEST(ScaleTextTest, TellsTheChosenByWeightThenTheBestOfEachOtherEstimator) {
  EXPECT_EQ(ScaleText(TriedScales()),
            "  chosen by 512 points, noise up to 0.0123; expected error of mean_curvature:\n"
            "  estimator                       K      error   by noise by smoothing   weight\n"
            "  jet, degree 2                 256        0.2       0.15          0.1     50 %\n"
            "  avg-hexagram                   64        0.3       0.29            0     25 %\n"
            "  jet, degree 4                 256       0.25       0.25            0     25 %\n"
            "  normal-regression, degree 1   181        0.8        0.8            0      0 %\n");
}

TEST(ScaleTextTest, FitsInEightyColumns) {
  ScaleReport report = TriedScales();
  report.position_noise = 1.23456e-15;
  report.normal_noise = 1.23456e-15;
  report.fitted_normals = {NormalMethod::kJet4, 1536};
  report.normals_made_anew = {NormalMethod::kJet4, 1086};
  for (ScaleOutcome& outcome : report.outcomes)
    outcome = {outcome.estimator, 3, 2048, 1.2345e-100, 1.2345e-100, 1.2345e-100, 1.0};
  const std::string text = ScaleText(report);
  for (size_t start = 0, end; (end = text.find('\n', start)) != std::string::npos; start = end + 1) {
    EXPECT_LE(end - start, 80u) << text.substr(start, end - start);
  }
}

TEST(ScaleTextTest, SaysWhenNothingCouldBeJudged) {
  EXPECT_THAT(ScaleText({}), HasSubstr("too few points"));
  EXPECT_EQ(ScaleJson({}).dump(),
            R"({"sampled_points":0,"position_noise":0.0,"normal_noise":null,"fitted_normals":null,)"
            R"("normals_made_anew":null,"outcomes":[]})");
}

TEST(ScaleTextTest, TellsWhatGivenNormalsWereMadeBy) {
  ScaleReport report = TriedScales();
  report.fitted_normals = {NormalMethod::kPca, 30};
  EXPECT_THAT(ScaleText(report), HasSubstr("\n  given normals: pca of 30 points, whose halves told their noise\n"));
  EXPECT_EQ(ScaleJson(report)["fitted_normals"].dump(), R"({"method":"pca","neighbor_count":30})");
  report.normals_made_anew = {NormalMethod::kJet2, 192};
  EXPECT_THAT(ScaleText(report), HasSubstr("\n  given normals: pca of 30 points, made anew: jet-2 of 192 points\n"));
  EXPECT_EQ(ScaleJson(report)["normals_made_anew"].dump(), R"({"method":"jet-2","neighbor_count":192})");
  report.fitted_normals.reset();
  EXPECT_THAT(ScaleText(report),
              HasSubstr("\n  given normals: made of the positions, made anew: jet-2 of 192 points\n"));
}

TEST(ScaleTextTest, JsonTellsEverythingThatWasJudged) {
  const nlohmann::ordered_json json = ScaleJson(TriedScales());
  EXPECT_EQ(json["outcomes"].size(), 7u);
  EXPECT_EQ(json["outcomes"][0].dump(),
            R"({"estimator":"avg-hexagram","degree":0,"neighbor_count":64,"error":0.3,"noise":0.29,"bias":0.0,)"
            R"("share":0.25})");
  EXPECT_EQ(json["outcomes"][2]["degree"], 2);
}

TEST(FlagsTest, ParsesVectorsAndDirections) {
  std::array<double, 3> vector;
  EXPECT_TRUE(ParseVector("1,-2.5,3e2", vector));
  EXPECT_EQ(vector, (std::array<double, 3>{1.0, -2.5, 300.0}));
  for (const char* text : {"", "1", "1,2", "1,2,", ",2,3", "1,2,3,4", "1,2,nan", "1,inf,2", "1, 2,3", "a,b,c"}) {
    EXPECT_FALSE(ParseVector(text, vector)) << text;
  }
  EXPECT_TRUE(ParseDirection("-y", vector));
  EXPECT_EQ(vector, (std::array<double, 3>{0.0, -1.0, 0.0}));
  EXPECT_TRUE(ParseDirection("z", vector));
  EXPECT_EQ(vector, (std::array<double, 3>{0.0, 0.0, 1.0}));
  EXPECT_TRUE(ParseDirection("0,0,-2", vector));
  for (const char* text : {"", "-", "w", "xy", "--x", "0,0,0", "1,2"})
    EXPECT_FALSE(ParseDirection(text, vector)) << text;
}

TEST(FlagsTest, ParsesRangesAndSizes) {
  double low, high;
  EXPECT_TRUE(ParseRange("-0.107:0.345", low, high));
  EXPECT_EQ(low, -0.107);
  for (const char* text : {"", ":", "1", "1:", ":1", "1:1", "2:1", "nan:1", "0:inf", "0:1:2", "-1e308:1e308"}) {
    EXPECT_FALSE(ParseRange(text, low, high)) << text;
  }
  int width, height;
  EXPECT_TRUE(ParseSize("64x4096", 64, 4096, width, height));
  EXPECT_EQ(height, 4096);
  for (const char* text : {"", "x", "64", "64x", "x64", "63x64", "64x4097", "64X64", "64x64x64", "-64x64"}) {
    EXPECT_FALSE(ParseSize(text, 64, 4096, width, height)) << text;
  }
}

}  // namespace
}  // namespace curv
