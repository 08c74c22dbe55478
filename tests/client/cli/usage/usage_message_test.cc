#include "client/cli/usage/usage_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/client/cli/run_curv.h"

namespace curv {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// What a command says of flags, before it looks for its input, which is not there.
std::string Refusal(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {arguments.front(), "nowhere.ply", "-o", "out.ply"};
  words.insert(words.end(), arguments.begin() + 1, arguments.end());
  const CurvRun run = RunCurv(words);
  EXPECT_EQ(run.exit_code, 2) << arguments.back() << run.err;
  EXPECT_THAT(run.err, HasSubstr("\nRun curv " + arguments.front() + " --help")) << arguments.back();
  return run.err;
}

TEST(UsageMessageTest, AnEmptyValueIsToldWhatThereIs) {
  constexpr char kEmpty[] = ": its value is missing or empty: ";
  const struct {
    std::string flag, meaning;
  } kFlags[] = {
      {"--normals", "it must be given, orient or estimate\n"},
      {"--on-invalid", "it must be reject or skip\n"},
      {"--on-opposed-normals", "it must be mark or reject\n"},
      {"--summary", "it must be text or json\n"},
      {"--format", "it must be ply, "},
      {"--estimator", "it must be avg-hexagram, "},
      {"--also", "what to estimate beside that: shape_index, curvedness; standard_errors, of auto"},
      {"--direction", "add the normal curvature in a direction, projected on the tangent plane: an axis, or X,Y,Z\n"},
      {"--server-name", "name in the server's certificate [the host of --server]\n"},
  };
  for (const auto& [flag, meaning] : kFlags) {
    EXPECT_THAT(Refusal({"estimate", flag + "="}), StartsWith("curv: " + flag + kEmpty + meaning));
  }
  EXPECT_THAT(Refusal({"estimate", "--summary"}), HasSubstr("it must be text or json\n"));
}

TEST(UsageMessageTest, FlagsThatNeedNoValueTakeNoEmptyOne) {
  const std::vector<std::string> kRuns[] = {{"orient", "--up="},    {"normals", "--up="},
                                            {"estimate", "--up="},  {"estimate", "--normals=orient", "--up="},
                                            {"estimate", "--tls="}, {"estimate", "--color="},
                                            {"normals", "--ascii="}};
  for (const std::vector<std::string>& arguments : kRuns) {
    EXPECT_THAT(Refusal(arguments), StartsWith("curv: " + arguments.back().substr(0, arguments.back().size() - 1) +
                                               ": its value is empty: "));
  }
  EXPECT_THAT(Refusal({"estimate", "--color="}), HasSubstr("it must be mean, gaussian, k1 or k2\n"));
  EXPECT_EQ(RunCurv({"normals", "nowhere.ply", "-o", "out.ply", "--up"}).exit_code, 3);
  // Behind the mark it is the name of a file.
  EXPECT_THAT(RunCurv({"orient", "-o", "out.ply", "--", "--up="}).err, Not(HasSubstr("is empty")));
}

TEST(UsageMessageTest, AFlagGivenTwiceIsTold) {
  EXPECT_THAT(Refusal({"estimate", "--estimator=jet", "--estimator=aso"}),
              StartsWith("curv: --estimator: is given 2 times: give it once\n"));
}

}  // namespace
}  // namespace curv
