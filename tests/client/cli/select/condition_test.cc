#include "client/cli/select/condition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

PointTable Sample() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  PointTable table;
  table.Set({"x", std::vector<double>{0, 1, 2, 3}});
  table.Set({"k1", std::vector<float>{-0.5f, 0.25f, kNaN, 1.0f}});
  table.Set({"k2", std::vector<float>{0.5f, 0.5f, kNaN, 2.0f}});
  table.Set({"status", std::vector<uint8_t>{1, 1, 3, 1}});
  table.Set({"echo width", std::vector<int16_t>{-4, 0, 4, 8}});
  table.Set({"or", std::vector<uint8_t>{1, 0, 0, 0}});
  return table;
}

std::vector<size_t> Rows(const std::string& text) {
  const PointTable table = Sample();
  const absl::StatusOr<Condition> condition = Condition::Parse(text, table);
  EXPECT_TRUE(condition.ok()) << text << ": " << condition.status();
  return condition.ok() ? condition->Rows() : std::vector<size_t>();
}

std::string Message(const std::string& text) {
  const PointTable table = Sample();
  return std::string(Condition::Parse(text, table).status().message());
}

TEST(ConditionTest, Compares) {
  EXPECT_THAT(Rows("x < 1"), ElementsAre(0));
  EXPECT_THAT(Rows("x <= 1"), ElementsAre(0, 1));
  EXPECT_THAT(Rows("1<x"), ElementsAre(2, 3));
  EXPECT_THAT(Rows("x >= 3"), ElementsAre(3));
  EXPECT_THAT(Rows("x == 2e0"), ElementsAre(2));
  EXPECT_THAT(Rows("x != 2"), ElementsAre(0, 1, 3));
  EXPECT_THAT(Rows("x > 9"), IsEmpty());
}

TEST(ConditionTest, JoinsByTheUsualOrder) {
  EXPECT_THAT(Rows("k2 > 0.5 and status == ok"), ElementsAre(3));
  EXPECT_THAT(Rows("x == 0 or x == 1 and k1 > 5"), ElementsAre(0)) << "and binds tighter than or";
  EXPECT_THAT(Rows("(x == 0 or x == 1) and k1 > 5"), IsEmpty());
  EXPECT_THAT(Rows("not x == 0 and x < 2"), ElementsAre(1)) << "not binds tighter than and";
  EXPECT_THAT(Rows("not (x == 0 and x < 2)"), ElementsAre(1, 2, 3));
  EXPECT_THAT(Rows("not not x == 0"), ElementsAre(0));
  EXPECT_THAT(Rows("((x == 0))"), ElementsAre(0));
}

TEST(ConditionTest, Calculates) {
  EXPECT_THAT(Rows("x * 2 + 1 == 5"), ElementsAre(2));
  EXPECT_THAT(Rows("1 + x * 2 == 5"), ElementsAre(2)) << "products bind tighter";
  EXPECT_THAT(Rows("x - 1 - 1 == 0"), ElementsAre(2)) << "from the left";
  EXPECT_THAT(Rows("8 / x / 2 == 2"), ElementsAre(2));
  EXPECT_THAT(Rows("(k1 + k2) / 2 == 0"), ElementsAre(0));
  EXPECT_THAT(Rows("abs(k1) == 0.5"), ElementsAre(0));
  EXPECT_THAT(Rows("abs(x - 2) < 1.5 and -k1 < 0"), ElementsAre(1, 3));
  EXPECT_THAT(Rows("--x == +1"), ElementsAre(1));
  EXPECT_THAT(Rows("1 / x > 1e300"), ElementsAre(0)) << "as IEEE 754 has it";
}

TEST(ConditionTest, NaNHoldsNothingButUnequal) {
  EXPECT_THAT(Rows("k1 == k1"), ElementsAre(0, 1, 3));
  EXPECT_THAT(Rows("k1 != k1"), ElementsAre(2));
  EXPECT_THAT(Rows("k1 > 0 or k1 <= 0"), ElementsAre(0, 1, 3));
  EXPECT_THAT(Rows("not k1 > 0"), ElementsAre(0, 2));
}

TEST(ConditionTest, KnowsTheWordsOfStatus) {
  EXPECT_THAT(Rows("status == degenerate_area"), ElementsAre(2));
  EXPECT_THAT(Rows("ok != status"), ElementsAre(2));
  EXPECT_THAT(Rows("status == 3"), ElementsAre(2));
  EXPECT_THAT(Rows("status == outlier"), IsEmpty());
  EXPECT_THAT(Message("status > ok"), HasSubstr("character 10: ok is a status: compare it with the column status"));
  EXPECT_THAT(Message("k1 == ok"), HasSubstr("ok is a status"));
  EXPECT_THAT(Message("ok"), HasSubstr("ok is a status"));
}

TEST(ConditionTest, QuotesNames) {
  EXPECT_THAT(Rows("\"echo width\" >= 4"), ElementsAre(2, 3));
  EXPECT_THAT(Rows("`echo width` < 0"), ElementsAre(0));
  EXPECT_THAT(Rows("\"or\" == 1 or x == 3"), ElementsAre(0, 3));
}

TEST(ConditionTest, ListsTheColumnsBesideAnUnknownOne) {
  EXPECT_THAT(Message("x > 0 and k3 > 1"),
              HasSubstr("character 11: there is no column \"k3\". The columns are: x k1 k2 status echo width or"));
  EXPECT_THAT(Message("exp(x) > 1"), HasSubstr("there is no column \"exp\""));
  EXPECT_THAT(Message("status == OK"),
              HasSubstr("no column \"OK\"; the word of a status is ok, without quotes. The columns"));
  EXPECT_THAT(Message("status == \"singular_fit\""), HasSubstr("the word of a status is singular_fit, without quotes"));
}

TEST(ConditionTest, NamesWhatIsWrong) {
  EXPECT_THAT(Message(""), HasSubstr("character 1: expected a column, a number or a parenthesis, found the end"));
  EXPECT_THAT(Message("x"), HasSubstr("character 1: expected a comparison, as k2 > 0.5, found a number"));
  EXPECT_THAT(Message("x > "), HasSubstr("character 5: expected a column"));
  EXPECT_THAT(Message("x = 1"), HasSubstr("character 3: \"=\" is not known: write =="));
  EXPECT_THAT(Message("x > 1 && x < 2"), HasSubstr("\"&&\" is not known: write and"));
  EXPECT_THAT(Message("!x"), HasSubstr("write not"));
  EXPECT_THAT(Message("0 < x < 1"), HasSubstr("character 7: comparisons cannot be chained"));
  EXPECT_THAT(Message("(x > 1"), HasSubstr("expected ), found the end"));
  EXPECT_THAT(Message("x > 1)"), HasSubstr("character 6: expected and, or, or the end, found \")\""));
  EXPECT_THAT(Message("x > 1 x < 2"), HasSubstr("found \"x\""));
  EXPECT_THAT(Message("(x > 1) + 2 > 0"), HasSubstr("expected a number, found a comparison"));
  EXPECT_THAT(Message("x and x > 1"), HasSubstr("found a number"));
  EXPECT_THAT(Message("abs(x > 1) > 0"), HasSubstr("expected a number"));
  EXPECT_THAT(Message("x > 1e999"), HasSubstr("a number in the range of double, found \"1e999\""));
  EXPECT_THAT(Message("x > 1x"), HasSubstr("found \"1x\""));
  EXPECT_THAT(Message("x > \"y"), HasSubstr("not closed"));
  EXPECT_THAT(Message("x > $y"), HasSubstr("character 5: found \"$\""));
  EXPECT_THAT(Message(std::string(100'000, '(') + "x > 1"), HasSubstr("expected at most 10000"));
  EXPECT_THAT(Message(std::string(1000, '(') + "x > 1"), HasSubstr("more than 200 levels"));
  EXPECT_THAT(Message(std::string(1000, '-') + "x > 1"), HasSubstr("more than 200 levels"));
}

// Whatever the text, there is a condition or a message.
TEST(ConditionTest, SurvivesTruncationAndDamage) {
  const PointTable table = Sample();
  const std::string text = "not (k2 > 0.5 and \"echo width\" <= -1e3) or abs(x*2/3+1) != 4 and status == ok";
  ASSERT_TRUE(Condition::Parse(text, table).ok());
  for (size_t at = 0; at < text.size(); ++at) {
    const absl::StatusOr<Condition> prefix = Condition::Parse(text.substr(0, at), table);
    EXPECT_TRUE(prefix.ok() || !prefix.status().message().empty());
    for (const char change : {'\0', '(', ')', '"', '-', '9', 'e', '\xff'}) {
      std::string damaged = text;
      damaged[at] = change;
      const absl::StatusOr<Condition> condition = Condition::Parse(damaged, table);
      if (condition.ok()) {
        EXPECT_LE(condition->Rows().size(), 4u);
      }
    }
  }
}

TEST(ConditionTest, SelectsRowsOfManyBlocks) {
  PointTable table;
  std::vector<double> x(10'000);
  for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
  table.Set({"x", x});
  table.viewpoint = {1, 2, 3};
  const std::vector<size_t> rows = Condition::Parse("x > 4094.5 and x < 8193", table)->Rows();
  const PointTable selected = SelectRows(table, rows);
  EXPECT_EQ(selected.size(), 4098u);
  EXPECT_EQ(selected.Find("x")->At(0), 4095);
  EXPECT_EQ(selected.viewpoint, table.viewpoint);
}

}  // namespace
}  // namespace curv
