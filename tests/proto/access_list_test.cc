#include "proto/access_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// `printf %s secret | sha256sum`
constexpr char kSecretHash[] = "sha256:2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b";

TEST(HashTokenTest, IsSha256) { EXPECT_EQ(FormatHash(HashToken("secret")), kSecretHash); }

TEST(ParseTokenFileTest, ReadsNamesHashesAndLimits) {
  const auto entries =
      ParseTokenFile(absl::StrCat("# who may call\n\nalice ", kSecretHash, "\n  bob\t", FormatHash(HashToken("other")),
                                  " max-points=1000 max-streams=2 \r\n"));
  ASSERT_TRUE(entries.ok()) << entries.status();
  ASSERT_EQ(entries->size(), 2u);
  EXPECT_EQ((*entries)[0].name, "alice");
  EXPECT_EQ((*entries)[0].max_streams, 0u);
  EXPECT_EQ((*entries)[0].max_points, 0u);
  EXPECT_EQ((*entries)[1].name, "bob");
  EXPECT_EQ((*entries)[1].max_streams, 2u);
  EXPECT_EQ((*entries)[1].max_points, 1000u);
}

TEST(ParseTokenFileTest, AFileWithoutAnEntryLetsNobodyIn) {
  const auto entries = ParseTokenFile("# all revoked\n");
  ASSERT_TRUE(entries.ok());
  EXPECT_TRUE(entries->empty());
}

TEST(ParseTokenFileTest, NamesTheLineButNeverQuotesIt) {
  for (const std::string line : {"alice", "alice secret-token", "alice sha256:secret-token",
                                 "alice sha256:", "\"secret-token\" sha256:", "alice md5:0123"}) {
    const auto entries = ParseTokenFile(absl::StrCat("bob ", kSecretHash, "\n", line, "\n"));
    EXPECT_EQ(entries.status().code(), absl::StatusCode::kInvalidArgument) << line;
    const std::string message(entries.status().message());
    EXPECT_THAT(message, HasSubstr("line 2: "));
    EXPECT_THAT(message, Not(HasSubstr("secret-token")));
  }
}

TEST(ParseTokenFileTest, RefusesEachTruncationOfAHash) {
  const std::string line = absl::StrCat("alice ", kSecretHash);
  for (size_t length = 1; length < line.size(); ++length) {
    EXPECT_FALSE(ParseTokenFile(line.substr(0, length)).ok()) << length;
  }
  EXPECT_FALSE(ParseTokenFile(line + "0").ok());
  EXPECT_TRUE(ParseTokenFile(line).ok());
}

TEST(ParseTokenFileTest, RefusesLimitsThatAreNone) {
  for (const char* limit : {"max-streams=0", "max-streams=-1", "max-streams=", "max-points=0", "max-points=1e6",
                            "max-points=99999999999999999999", "max-tokens=3", "4"}) {
    EXPECT_FALSE(ParseTokenFile(absl::StrCat("alice ", kSecretHash, " ", limit)).ok()) << limit;
  }
}

TEST(ParseNameFileTest, ReadsNamesAndLimits) {
  const auto entries = ParseNameFile("scanner-7.example.com\nspiffe://example.com/lab max-streams=1\n");
  ASSERT_TRUE(entries.ok()) << entries.status();
  ASSERT_EQ(entries->size(), 2u);
  EXPECT_EQ((*entries)[1].name, "spiffe://example.com/lab");
  EXPECT_EQ((*entries)[1].max_streams, 1u);
}

}  // namespace
}  // namespace curvd
