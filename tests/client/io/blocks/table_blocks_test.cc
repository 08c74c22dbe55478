#include "client/io/blocks/table_blocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "client/io/table_file.h"
#include "client/io/writing/table_stream.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

PointTable Cloud(size_t points) {
  PointTable table;
  std::vector<float> x, y, z;
  std::vector<uint8_t> tag;
  for (size_t i = 0; i < points; ++i) {
    x.push_back(static_cast<float>(i) * 0.25f);
    y.push_back(1.0f - static_cast<float>(i));
    z.push_back(static_cast<float>(i % 7));
    tag.push_back(static_cast<uint8_t>(i));
  }
  table.Set({"x", x});
  table.Set({"y", y});
  table.Set({"z", z});
  table.Set({"tag", tag});
  return table;
}

// Puts the blocks of a file together again, and counts them.
PointTable Joined(TableBlocks& blocks, size_t& count) {
  PointTable joined;
  count = 0;
  while (true) {
    absl::StatusOr<PointTable> block = blocks.Next();
    EXPECT_TRUE(block.ok()) << block.status();
    if (!block.ok() || block->size() == 0) return joined;
    ++count;
    if (joined.columns().empty()) {
      joined = *std::move(block);
      continue;
    }
    std::vector<Column> columns = joined.Release();
    for (size_t c = 0; c < columns.size(); ++c) {
      std::visit(
          [&](auto& values) {
            const auto& more = std::get<std::decay_t<decltype(values)>>(block->columns()[c].values);
            values.insert(values.end(), more.begin(), more.end());
          },
          columns[c].values);
    }
    for (Column& column : columns) joined.Set(std::move(column));
  }
}

void ExpectSame(const PointTable& read, const PointTable& expected) {
  ASSERT_EQ(read.columns().size(), expected.columns().size());
  for (size_t c = 0; c < read.columns().size(); ++c) {
    EXPECT_EQ(read.columns()[c].name, expected.columns()[c].name);
    EXPECT_EQ(read.columns()[c].values, expected.columns()[c].values);
  }
}

class Formats : public ::testing::TestWithParam<const char*> {};

TEST_P(Formats, GivesBlockByBlockWhatTheWholeFileHolds) {
  const TempDir folder;
  const std::string path = folder.File(std::string("cloud") + GetParam());
  ASSERT_TRUE(SaveTable(Cloud(1000), path).ok());
  const auto blocks = TableBlocks::Open(path, "", 1 << 10, 0);
  ASSERT_TRUE(blocks.ok()) << blocks.status();
  EXPECT_FALSE((*blocks)->is_whole());
  size_t count;
  ExpectSame(Joined(**blocks, count), *LoadTable(path));
  EXPECT_GT(count, 5u);
}

INSTANTIATE_TEST_SUITE_P(Streamed, Formats, ::testing::Values(".ply", ".pcd", ".las", ".npy", ".csv", ".xyz"));

class Whole : public ::testing::TestWithParam<const char*> {};

TEST_P(Whole, ReadsOtherFilesAtOnceIfTheyFit) {
  const TempDir folder;
  const std::string path = folder.File(std::string("cloud") + GetParam());
  ASSERT_TRUE(SaveTable(Cloud(1000), path).ok());
  const auto blocks = TableBlocks::Open(path, "", 1 << 10, 1 << 20);
  ASSERT_TRUE(blocks.ok()) << blocks.status();
  EXPECT_TRUE((*blocks)->is_whole());
  size_t count;
  ExpectSame(Joined(**blocks, count), *LoadTable(path));
  const auto too_large = TableBlocks::Open(path, "", 1 << 10, 100);
  EXPECT_TRUE(absl::IsResourceExhausted(too_large.status()));
  EXPECT_THAT(std::string(too_large.status().message()), HasSubstr("--memory"));
}

INSTANTIATE_TEST_SUITE_P(Packed, Whole, ::testing::Values(".npz", ".ply.gz"));

TEST(TableBlocks, TellsThatAFileEndsTooEarly) {
  const TempDir folder;
  const std::string path = folder.File("cloud.ply");
  ASSERT_TRUE(SaveTable(Cloud(1000), path).ok());
  folder.Write("short.ply", folder.Read("cloud.ply").substr(0, 9'000));
  const auto blocks = TableBlocks::Open(folder.File("short.ply"), "", 1 << 10, 0);
  ASSERT_TRUE(blocks.ok()) << blocks.status();
  EXPECT_THAT(std::string((*blocks)->Next().status().message()),
              HasSubstr("the file ends too early: 1000 points of 13 bytes are declared, 8"));
}

// Reads a text file in blocks, of which there are several, and returns the error that it ends with.
absl::Status ErrorOfBlocks(const std::string& ending, const std::string& text, PointTable* table = nullptr) {
  const TempDir folder;
  folder.Write("cloud" + ending, text);
  const auto blocks = TableBlocks::Open(folder.File("cloud" + ending), "", 1 << 10, 0);
  if (!blocks.ok()) return blocks.status();
  while (true) {
    absl::StatusOr<PointTable> block = (*blocks)->Next();
    if (!block.ok() || block->size() == 0) return block.status();
    if (table != nullptr) *table = *std::move(block);
  }
}

std::string Repeated(const std::string& line, size_t times) {
  std::string lines;
  for (size_t i = 0; i < times; ++i) lines += line;
  return lines;
}

TEST(TableBlocks, NumbersTheLinesOfTextAsTheFileDoes) {
  const std::string points = Repeated("1,2,3\r\n", 500) + "\n# or not\n1,2,three\n" + Repeated("1,2,3\n", 500);
  for (const auto& [ending, start, line] : std::vector<std::tuple<const char*, const char*, const char*>>{
           {".xyz", "", "line 503: "}, {".xyz", "\xef\xbb\xbf# by hand\n# x y z\n1001\n", "line 506: "}}) {
    EXPECT_THAT(std::string(ErrorOfBlocks(ending, start + points).message()), HasSubstr(std::string(": ") + line));
  }
  const std::string cells = "x,y,z\n" + Repeated("1,2,3\n", 500) + "\n1,2\n";
  EXPECT_THAT(std::string(ErrorOfBlocks(".csv", cells).message()), HasSubstr("cloud.csv: line 503: expected 3 values"));
}

TEST(TableBlocks, KeepsTheNamesOfACommentBehindAByteOrderMark) {
  PointTable last;
  ASSERT_TRUE(ErrorOfBlocks(".xyz", "\xef\xbb\xbf# x y z height\n" + Repeated("1 2 3 4\n", 500), &last).ok());
  EXPECT_NE(last.Find("height"), nullptr);
}

// As ReadCsv does with the whole file.
TEST(TableBlocks, LeavesOutAColumnOfWordsWhereABlockBeginsWithANumber) {
  PointTable last;
  const std::string cells = Repeated("1,2,3,7\n", 300) + "1,2,3,tree\n";
  const absl::Status status = ErrorOfBlocks(".csv", "x,y,z,class\n1,2,3,tree\n" + cells + cells, &last);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(last.Find("class"), nullptr);
}

TEST(TableBlocks, RefusesStandardInput) { EXPECT_FALSE(TableBlocks::Open("-", "ply", 1 << 10, 1 << 20).ok()); }

class Streams : public ::testing::TestWithParam<const char*> {};

TEST_P(Streams, WritesTheBytesOfOneTable) {
  const TempDir folder;
  const std::string ending = GetParam(), whole = folder.File("whole" + ending), parts = folder.File("parts" + ending);
  ASSERT_TRUE(SaveTable(Cloud(1000), whole).ok());
  ASSERT_TRUE(TableStream::CanWrite(parts, {}));
  const auto stream = TableStream::Create(parts, {}, Cloud(1), 2000);
  ASSERT_TRUE(stream.ok()) << stream.status();
  ASSERT_TRUE((*stream)->Append(Cloud(1000)).ok());
  ASSERT_TRUE((*stream)->Append(Cloud(1000)).ok());
  EXPECT_FALSE(folder.Has("parts" + ending));
  ASSERT_TRUE((*stream)->Commit().ok());
  const absl::StatusOr<PointTable> read = LoadTable(parts), once = LoadTable(whole);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2 * once->size());
  for (size_t c = 0; c < read->columns().size(); ++c) {
    for (size_t i = 0; i < read->size(); i += 37) {
      EXPECT_EQ(read->columns()[c].At(i), once->columns()[c].At(i % once->size()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Streams, ::testing::Values(".ply", ".pcd", ".npy", ".csv", ".xyz", ".ply.gz"));

TEST(TableStream, LeavesToOthersWhatIsWrittenAsAWhole) {
  EXPECT_FALSE(TableStream::CanWrite("cloud.las", {}));
  EXPECT_FALSE(TableStream::CanWrite("cloud.npz", {}));
}

}  // namespace
}  // namespace curv
