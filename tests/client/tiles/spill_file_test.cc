#include "client/tiles/spill_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

std::string RecordOf(size_t number) { return "record " + std::to_string(number) + "\n"; }

std::string ReadAll(const SpillFile& spill, size_t bucket) {
  std::string bytes;
  EXPECT_TRUE(spill
                  .Read(bucket,
                        [&](std::string_view records) {
                          bytes += records;
                          return absl::OkStatus();
                        })
                  .ok());
  return bytes;
}

TEST(SpillFile, KeepsTheRecordsOfEachBucketInOrder) {
  constexpr size_t kBuckets = 3, kRecords = 20'000;  // several pieces a bucket
  const testing::ScratchDirectory scratch;
  const auto spill = SpillFile::Create(scratch.PathOf(""), kBuckets, 1);
  ASSERT_TRUE(spill.ok()) << spill.status();
  std::string wanted[kBuckets];
  for (size_t i = 0; i < kRecords; ++i) {
    const std::string text = RecordOf(i);
    const size_t bucket = (i / 2) % 2;  // nothing goes into the last
    char* record = nullptr;
    ASSERT_TRUE((*spill)->Extend(bucket, text.size(), record).ok());
    text.copy(record, text.size());
    wanted[bucket] += text;
  }
  ASSERT_TRUE((*spill)->Finish().ok());
  for (size_t bucket = 0; bucket < kBuckets; ++bucket) EXPECT_EQ(ReadAll(**spill, bucket), wanted[bucket]);
  (*spill)->Drop(0);
  EXPECT_EQ(ReadAll(**spill, 0), "");
  EXPECT_EQ(ReadAll(**spill, 1), wanted[1]);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.PathOf("")));  // it has no name
}

TEST(SpillFile, SaysWhereItCannotWrite) {
  const testing::ScratchDirectory scratch;
  const auto spill = SpillFile::Create(scratch.PathOf("missing"), 1, 1);
  EXPECT_EQ(spill.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_NE(spill.status().message().find("missing"), std::string::npos);
}

}  // namespace
}  // namespace curv
