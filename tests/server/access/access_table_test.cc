#include "server/access/access_table.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

AccessEntry Entry(const std::string& name, const std::string& token = "", uint32_t max_streams = 0) {
  AccessEntry entry;
  entry.name = name;
  entry.token_hash = HashToken(token);
  entry.max_streams = max_streams;
  return entry;
}

TEST(AccessTableTest, FindsTheTokenThatWasHashed) {
  const AccessTable table({Entry("old", "other"), Entry("alice", "secret")});
  ASSERT_NE(table.FindHash(HashToken("secret")), nullptr);
  EXPECT_EQ(table.FindHash(HashToken("secret"))->name, "alice");
  for (const char* wrong : {"", "Secret", "secret ", "secre"}) {
    EXPECT_EQ(table.FindHash(HashToken(wrong)), nullptr) << wrong;
  }
}

TEST(AccessTableTest, ATokenThatStandsTwiceIsThatOfTheLastLine) {
  const AccessTable table({Entry("alice", "secret", 1), Entry("alice", "secret", 2)});
  EXPECT_EQ(table.FindHash(HashToken("secret"))->max_streams, 2u);
}

TEST(AccessTableTest, FindsTheFirstLineWithANameOfACertificate) {
  const AccessTable table({Entry("a", "", 1), Entry("b", "", 2), Entry("a", "", 3)});
  EXPECT_EQ(table.FindName({"b", "a"})->max_streams, 1u);
  EXPECT_EQ(table.FindName({"x", "b"})->max_streams, 2u);
  EXPECT_EQ(table.FindName({"x", ""}), nullptr);
  EXPECT_EQ(table.FindName({}), nullptr);
}

TEST(AccessTableTest, AnEmptyTableKnowsNobody) {
  const AccessTable table({});
  EXPECT_EQ(table.FindHash(HashToken("")), nullptr);
  EXPECT_EQ(table.FindHash(Sha256()), nullptr);
  EXPECT_EQ(table.FindName({"a"}), nullptr);
}

// With a look at each entry it would take some minutes, and every call would wait meanwhile.
TEST(AccessTableTest, LooksUpInALongListAsInAShortOne) {
  constexpr int kEntries = 100'000;
  std::vector<AccessEntry> entries;
  for (int i = 0; i < kEntries; ++i) entries.push_back(Entry(absl::StrCat("n", i), absl::StrCat("t", i)));
  const std::vector<AccessEntry> same = entries;
  const AccessTable table(std::move(entries));
  for (const AccessEntry& entry : same) {
    ASSERT_EQ(table.FindHash(entry.token_hash)->name, entry.name);
    ASSERT_EQ(table.FindName({entry.name})->token_hash, entry.token_hash);
  }
}

}  // namespace
}  // namespace curvd
