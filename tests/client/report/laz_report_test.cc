#include "client/report/laz_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "absl/strings/escaping.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Bytes(const std::string& name) {
  std::ifstream file(std::string(PDAL_FILES) + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <typename T>
std::string With(std::string bytes, size_t at, T value) {
  return bytes.replace(at, sizeof(value), std::string(reinterpret_cast<const char*>(&value), sizeof(value)));
}

uint32_t PointsAt(const std::string& bytes) {
  uint32_t at;
  std::memcpy(&at, &bytes[96], sizeof(at));
  return at;
}

std::string Message(std::string bytes) {
  const absl::StatusOr<LazFile> file = ReadLazFile(std::move(bytes));
  EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(file.status().message());
}

std::string Part(const std::string& page, const std::string& id) {
  const std::string begin = "id=\"" + id + "\">";
  const size_t at = page.find(begin) + begin.size();
  return page.substr(at, page.find("</script>", at) - at);
}

LazFile Read(const std::string& name) {
  absl::StatusOr<LazFile> file = ReadLazFile(Bytes(name));
  EXPECT_TRUE(file.ok()) << name << ": " << file.status();
  return file.ok() ? *std::move(file) : LazFile();
}

TEST(ReadLazFileTest, TakesWhatLaszipAndCopcWrite) {
  for (const char* name : {"terrain_3.laz", "terrain_7.laz", "terrain_7.copc.laz"}) {
    EXPECT_EQ(Read(name).layout.header.points, 300u) << name;
  }
}

TEST(ReadLazFileTest, RefusesEveryTruncationOfHeaderAndPoints) {
  const std::string good = Bytes("terrain_7.laz");
  int64_t table_at;
  std::memcpy(&table_at, &good[PointsAt(good)], sizeof(table_at));
  // Behind the points is the table of chunks, whose own compressed bytes come after its head of 8.
  ASSERT_GT(static_cast<size_t>(table_at) + 16, good.size());
  for (size_t size = 0; size < static_cast<size_t>(table_at) + 8; ++size) {
    ASSERT_FALSE(ReadLazFile(good.substr(0, size)).ok()) << size;
  }
}

TEST(ReadLazFileTest, RefusesCountsThatLie) {
  const std::string good = With(Bytes("terrain_7.laz"), 107, uint32_t{0});
  EXPECT_THAT(Message(With(good, 247, uint64_t{1'000'000'000})), HasSubstr("number of point records is 1000000000"));
  EXPECT_THAT(Message(With(good, 247, uint64_t{0})), HasSubstr("holds no points"));
  // As many as the bytes may stand for, but in one chunk.
  EXPECT_THAT(Message(With(good, 247, uint64_t{100'000})), HasSubstr("has 1 of them: expected 2, for 100000 points"));
}

TEST(ReadLazFileTest, RefusesTablesOfChunksThatCannotBe) {
  const std::string good = Bytes("terrain_7.laz");
  const uint32_t points_at = PointsAt(good);
  for (const int64_t at : {int64_t{-1}, int64_t{0}, int64_t{points_at} - 1, static_cast<int64_t>(good.size()) - 7,
                           std::numeric_limits<int64_t>::max()}) {
    EXPECT_THAT(Message(With(good, points_at, at)), HasSubstr("table of compressed chunks is at byte")) << at;
  }
  int64_t table_at;
  std::memcpy(&table_at, &good[points_at], sizeof(table_at));
  for (const uint32_t chunks : {0u, 2u, 0xFFFFFFFFu}) {
    EXPECT_THAT(Message(With(good, static_cast<size_t>(table_at) + 4, chunks)),
                HasSubstr("expected 1, for 300 points"));
  }
}

TEST(ReadLazFileTest, RefusesFormatsThatTheCodecDoesNotKnow) {
  const std::string good = Bytes("terrain_7.laz");
  // A record of format 9 would be longer.
  EXPECT_THAT(Message(With(With(good, 104, uint8_t{0x80 | 4}), 105, uint16_t{80})),
              HasSubstr("the point data record format is 4: the page decompresses 0 to 3 and 6 to 8"));
  EXPECT_THAT(Message(With(good, 25, uint8_t{1})), HasSubstr("the version is 1.1"));
}

TEST(ReadLazFileTest, RefusesWhatDoesNotSayHowItIsCompressed) {
  std::string good = Bytes("terrain_7.laz");
  good.replace(good.find("laszip encoded"), 6, "nobody");
  EXPECT_THAT(Message(std::move(good)), HasSubstr("the record \"laszip encoded\" 22204 is missing"));
}

TEST(ReadLazFileTest, RefusesBoxesThatCannotBe) {
  const std::string good = Bytes("terrain_7.laz");
  EXPECT_THAT(Message(With(good, 179, std::nan(""))), AllOf(HasSubstr("bounding box"), HasSubstr("along X")));
  EXPECT_THAT(Message(With(good, 219, 1e300)), AllOf(HasSubstr("bounding box"), HasSubstr("along Z")));
}

TEST(LazReportTest, KnowsTheColumnsThatReportsShow) {
  const LazFile file = Read("terrain_7.laz");
  EXPECT_TRUE(IsShownInReports(file, "intensity"));
  for (const char* column : {"nx", "x", "red", "status", "mean_curvature", ""}) {
    EXPECT_FALSE(IsShownInReports(file, column)) << column;
  }
}

TEST(LazReportTest, PageHoldsTheFileAsItIsAndWhereWhatStands) {
  const LazFile file = Read("terrain_7.laz");
  const std::string page = MakeLazPage(file, {.title = "a</script>.laz", .unit = "m", .most_points = 17});
  std::string bytes;
  ASSERT_TRUE(absl::Base64Unescape(Part(page, "points"), &bytes));
  EXPECT_EQ(bytes, file.bytes);
  const std::string text = Part(page, "report");
  EXPECT_THAT(text, Not(HasSubstr("<")));
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["title"], "a</script>.laz");
  EXPECT_EQ(json["points"], 300);
  EXPECT_EQ(json["up"], nullptr);
  EXPECT_EQ(json["laz"]["mostPoints"], 17);
  EXPECT_EQ(json["laz"]["layout"]["recordBytes"], 48);
  // Point format 7 has 36 bytes; then come three floats.
  const auto last = json["laz"]["layout"]["fields"].back();
  EXPECT_EQ(last, (nlohmann::json{{"name", "nz"}, {"type", 9}, {"at", 44}}));
  EXPECT_THAT(page, Not(HasSubstr("@curv-")));
}

TEST(LazReportTest, OnlyPagesThatDecompressCarryACodec) {
  const std::string page = MakeLazPage(Read("terrain_7.laz"), {});
  EXPECT_THAT(page, AllOf(HasSubstr("'wasm-unsafe-eval'"), HasSubstr("laz-perf"), Not(HasSubstr("'unsafe-eval'"))));
  EXPECT_THAT(MakeViewPage(/*reads_laz=*/true),
              AllOf(HasSubstr("'wasm-unsafe-eval'"), HasSubstr("connect-src 'self'")));
  EXPECT_THAT(MakeViewPage(), AllOf(Not(HasSubstr("wasm")), Not(HasSubstr("laz-perf"))));
}

TEST(LazReportTest, ServesTheFileAsItIs) {
  LazFile file = Read("terrain_7.laz");
  const std::string bytes = file.bytes;
  ReportShelf shelf;
  ServeLaz(std::move(file), {.title = "a.laz"}, 3, true, shelf);
  const auto served = shelf.Get();
  ASSERT_NE(served, nullptr);
  EXPECT_EQ(served->generation, 3u);
  const auto json = nlohmann::json::parse(served->report);
  EXPECT_EQ(json["generation"], 3);
  EXPECT_EQ(json["watches"], true);
  EXPECT_EQ(served->points->total(), bytes.size());
  EXPECT_EQ(served->points->Read(0, {}), bytes);
}

}  // namespace
}  // namespace curv
