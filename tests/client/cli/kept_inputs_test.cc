// No command replaces the file that it reads.
#include "client/cli/files/kept_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Pointee;

TEST(KeptInputsTest, FindsAFileUnderEachOfItsNames) {
  const TempDir dir;
  const std::string a = dir.Write("a.ply", "a"), b = dir.Write("b.ply", "b");
  fs::create_symlink(a, dir.File("soft.ply"));
  fs::create_hard_link(b, dir.File("hard.ply"));
  const KeptInputs kept({"-", dir.File("none.ply"), a, b});
  EXPECT_THAT(kept.ReplacedBy(dir.File("./a.ply")), Pointee(a));
  EXPECT_THAT(kept.ReplacedBy(dir.File("soft.ply")), Pointee(a));
  EXPECT_THAT(kept.ReplacedBy(dir.File("hard.ply")), Pointee(b));
  for (const std::string& other : {dir.Write("c.ply", "a"), dir.File("none.ply"), std::string("-")}) {
    EXPECT_EQ(kept.ReplacedBy(other), nullptr) << other;
    EXPECT_TRUE(kept.Check(other).ok());
  }
  EXPECT_EQ(kept.Check(a).message(), "--output: " + a + " would replace the input " + a + ": name another file");
}

TEST(KeptInputsTest, PipesAndDevicesAreNoFiles) {
  EXPECT_EQ(KeptInputs({"/dev/null"}).ReplacedBy("/dev/null"), nullptr);
}

TEST(KeptInputsTest, EachCommandRefusesAndLeavesTheFileAlone) {
  const TempDir dir;
  const std::string cloud = dir.File("cloud.ply");
  ASSERT_EQ(RunCurv({"generate", "torus", "--points=600", "-o", cloud}).exit_code, 0);
  const std::string before = dir.Read("cloud.ply");
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"estimate", cloud, "--k=20"},
           {"estimate", cloud, "--k=20", "--tiles", "--tiles-directory", dir.File("tiles")},
           {"select", cloud, "--where", "x > 0"},
           {"normals", cloud},
           {"orient", cloud}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"-o", cloud});
    const CurvRun run = RunCurv(arguments);
    EXPECT_EQ(run.exit_code, 2) << command[0];
    EXPECT_THAT(run.err, AllOf(HasSubstr("--output"), HasSubstr("would replace the input " + cloud))) << command[0];
  }
  ASSERT_EQ(RunCurv({"tiles", "plan", cloud, "--k=20", "-o", dir.File("plan")}).exit_code, 0);
  ASSERT_EQ(RunCurv({"tiles", "run", dir.File("plan")}).exit_code, 0);
  EXPECT_EQ(RunCurv({"tiles", "merge", dir.File("plan"), "-o", cloud}).exit_code, 2);
  EXPECT_EQ(dir.Read("cloud.ply"), before);
}

}  // namespace
}  // namespace curv
