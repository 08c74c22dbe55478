#include "client/io/long_integers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

bool AreDoubles(const std::string& bytes, bool is_signed) {
  Column column{"id", std::vector<double>()};
  return AppendLongIntegers(bytes.data(), bytes.size() / 8, 8, /*swap=*/false, is_signed, column);
}

TEST(LongIntegersTest, TellsWhichBitsAreDoubles) {
  constexpr int64_t k53 = int64_t{1} << 53;
  EXPECT_TRUE(AreDoubles(Pack(k53, -k53, k53 + 2, int64_t{1} << 62, INT64_MIN), true));
  EXPECT_FALSE(AreDoubles(Pack(k53 + 1), true));
  EXPECT_FALSE(AreDoubles(Pack(-k53 - 1), true));
  EXPECT_FALSE(AreDoubles(Pack(INT64_MAX), true)) << "the nearest double is 2^63";
  EXPECT_TRUE(AreDoubles(Pack(uint64_t{1} << 63), false));
  EXPECT_FALSE(AreDoubles(Pack(UINT64_MAX), false)) << "the nearest double is 2^64";
}

TEST(LongIntegersTest, TellsWhichDigitsAreRounded) {
  const auto is_rounded = [](const std::string& text) { return IsRounded(text, std::stod(text)); };
  for (const char* kept : {"0", "9007199254740992", "-9007199254740994", "+1000000000000000000000", "1e300",
                           "0.12345678901234567890", "000000000000000000001", "18446744073709551616"}) {
    EXPECT_FALSE(is_rounded(kept)) << kept;
  }
  for (const char* rounded : {"9007199254740993", "-9007199254740993", "+9007199254740993", "18446744073709551615",
                              "100000000000000000000001"}) {
    EXPECT_TRUE(is_rounded(rounded)) << rounded;
  }
}

TEST(LongIntegersTest, ReadersOfTextSayWhatTheyRound) {
  const absl::StatusOr<PointTable> csv = ReadCsv("x,y,z,id,big\n0,0,0,9007199254740993,9007199254740994\n");
  ASSERT_TRUE(csv.ok()) << csv.status();
  EXPECT_THAT(csv->notes, ElementsAre(HasSubstr("column id is rounded: integers beyond 2^53 are not all doubles")));
  const absl::StatusOr<PointTable> xyz =
      ReadXyz("# x y z id\n0 0 0 1\n0 0 0 9007199254740993\n0 0 0 9007199254740995\n");
  ASSERT_TRUE(xyz.ok()) << xyz.status();
  EXPECT_THAT(xyz->notes, ElementsAre(HasSubstr("column id is rounded")));
  EXPECT_THAT(ReadXyz("# x y z id\n0 0 0 9007199254740992\n")->notes, IsEmpty());
}

}  // namespace
}  // namespace curv
