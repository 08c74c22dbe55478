#include "client/report/served_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "client/report/report_page.h"
#include "client/report/thinning.h"

namespace curv {
namespace {

TEST(GrowingBytesTest, HandsOutEachPieceOnce) {
  GrowingBytes bytes(6);
  bytes.Append("ab");
  bytes.Append("cdef");
  EXPECT_EQ(bytes.Read(0, {}), "ab");
  EXPECT_EQ(bytes.Read(1, {}), "b");
  EXPECT_EQ(bytes.Read(2, {}), "cdef");
  EXPECT_EQ(bytes.Read(5, {}), "f");
  EXPECT_EQ(bytes.Read(6, {}), "");
}

TEST(GrowingBytesTest, WaitsForBytesUntilAStop) {
  GrowingBytes bytes(3);
  std::thread writer([&] { bytes.Append("abc"); });
  EXPECT_EQ(bytes.Read(0, {}), "abc");
  writer.join();
  GrowingBytes never(3);
  std::stop_source source;
  std::thread stopper([&] { source.request_stop(); });
  EXPECT_EQ(never.Read(0, source.get_token()), "");
  stopper.join();
}

TEST(ServeReportTest, ServesEachPointOnceInTheOrderOfTheHashes) {
  constexpr size_t kPoints = 300;
  PointTable table;
  for (const char* name : {"x", "y", "z"}) {
    std::vector<double> values(kPoints);
    for (size_t i = 0; i < kPoints; ++i) values[i] = static_cast<double>(i * (name[0] - 'w'));
    table.Set({name, values});
  }
  ReportShelf shelf;
  EXPECT_EQ(shelf.Get(), nullptr);
  ASSERT_TRUE(ServeReport(table, {.title = "t"}, 4, true, {}, shelf).ok());
  ASSERT_TRUE(shelf.AwaitFirst({}));
  const auto served = shelf.Get();
  const auto json = nlohmann::json::parse(served->report);
  EXPECT_EQ(json["generation"], 4);
  EXPECT_EQ(json["watches"], true);
  EXPECT_EQ(json["blocks"], nlohmann::json::array({kPoints}));
  size_t width = 0, index_at = 0;
  for (const auto& array : json["arrays"]) {
    if (array["name"] == "index_low") index_at = width * kPoints;
    width += array["bytes"].get<size_t>();
  }
  ASSERT_EQ(served->points->total(), width * kPoints);
  const std::string_view bytes = served->points->Read(0, {});
  ASSERT_EQ(bytes.size(), width * kPoints);
  std::vector<bool> seen(kPoints);
  uint32_t last_hash = 0;
  for (size_t i = 0; i < kPoints; ++i) {
    const auto byte = [&](size_t at) { return static_cast<uint32_t>(static_cast<uint8_t>(bytes[index_at + at])); };
    const uint32_t index = byte(i) | byte(kPoints + i) << 8;
    ASSERT_LT(index, kPoints);
    EXPECT_FALSE(seen[index]);
    seen[index] = true;
    EXPECT_GE(IndexHash(index), last_hash);
    last_hash = IndexHash(index);
  }
}

TEST(ServeReportTest, SaysWhatIsWaitedFor) {
  ReportShelf shelf;
  ServeWaiting("</script>.ply", shelf);
  EXPECT_EQ(nlohmann::json::parse(shelf.Get()->report)["waiting"], "</script>.ply");
  EXPECT_EQ(shelf.Get()->generation, 0u);
}

}  // namespace
}  // namespace curv
