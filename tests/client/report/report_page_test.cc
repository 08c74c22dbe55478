#include "client/report/report_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace curv {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

PointTable Line() {
  PointTable table;
  table.Set({"x", std::vector<double>{0, 1, 2}});
  table.Set({"y", std::vector<double>{5, 5, 5}});
  table.Set({"z", std::vector<double>{-1, -1, -3}});
  table.Set({"k1", std::vector<float>{1, 2, 3}});
  return table;
}

std::string ReportText(const std::string& page) {
  const std::string begin = R"(id="report">)";
  const size_t at = page.find(begin) + begin.size();
  return page.substr(at, page.find("</script>", at) - at);
}

TEST(MakeReportPageTest, TellsWhatThePointsAre) {
  const auto page = MakeReportPage(Line(), {.title = "line.ply", .unit = "mm", .up_axis = 'y'});
  ASSERT_TRUE(page.ok());
  const auto json = nlohmann::json::parse(ReportText(*page));
  EXPECT_EQ(json["title"], "line.ply");
  EXPECT_EQ(json["up"], "y");
  EXPECT_EQ(json["points"], 3);
  EXPECT_EQ(json["low"], nlohmann::json({0, 5, -3}));
  EXPECT_EQ(json["high"], nlohmann::json({2, 5, -1}));
  EXPECT_EQ(json["quantities"][0]["column"], "k1");
  EXPECT_THAT(*page, Not(HasSubstr("@curv-")));
  EXPECT_THAT(*page, HasSubstr("Content-Security-Policy"));
}

TEST(MakeReportPageTest, LetsNoNameEndItsElement) {
  PointTable table = Line();
  table.Set({"</script><script>alert(1)</script>", std::vector<float>(3)});
  table.Set({"\xff\xfe", std::vector<float>(3)});
  const auto page = MakeReportPage(table, {.title = "<b>", .unit = "</SCRIPT>"});
  ASSERT_TRUE(page.ok());
  const std::string text = ReportText(*page);
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(text)["title"], "<b>");
}

TEST(MakeReportPageTest, TakesOnePointAndHugeOnes) {
  PointTable one;
  for (const char* axis : {"x", "y", "z"}) one.Set({axis, std::vector<double>{7}});
  EXPECT_TRUE(MakeReportPage(one, {}).ok());
  PointTable huge;
  constexpr double kMost = std::numeric_limits<double>::max();
  for (const char* axis : {"x", "y", "z"}) huge.Set({axis, std::vector<double>{-kMost, kMost}});
  EXPECT_TRUE(MakeReportPage(huge, {}).ok());
}

TEST(MakeReportPageTest, RefusesACloudThatIsNowhere) {
  PointTable table;
  for (const char* axis : {"x", "y", "z"}) table.Set({axis, std::vector<double>{std::nan("")}});
  EXPECT_THAT(MakeReportPage(table, {}).status().message(), HasSubstr("no point with a finite position"));
}

}  // namespace
}  // namespace curv
