// Readers and writers in a program that has set a locale with a decimal comma, as one that embeds them may have.
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <locale>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/io/table_file.h"
#include "client/io/text.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

class LocaleTest : public ::testing::Test {
 protected:
  // Debian's machines have no locale but C unless asked. It takes a second to make one.
  static void SetUpTestSuite() {
    locales_ = new TempDir;
    const std::string make = absl::StrCat("localedef -i de_DE -f UTF-8 ", locales_->File("de_DE.UTF-8"));
    if (std::system(absl::StrCat(make, " >/dev/null 2>&1").c_str()) != 0) return;  // setlocale will tell
  }
  static void TearDownTestSuite() { delete locales_; }

  void SetUp() override {
    setenv("LOCPATH", locales_->File("").c_str(), 1);
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) {
      GTEST_SKIP() << "Debian's package locales is not installed";
    }
    std::locale::global(std::locale("de_DE.UTF-8"));
    ASSERT_EQ(std::localeconv()->decimal_point, std::string(","));
  }
  void TearDown() override {
    std::locale::global(std::locale::classic());
    unsetenv("LOCPATH");
  }

  static inline const TempDir* locales_ = nullptr;
  const TempDir dir_;
};

TEST_F(LocaleTest, NumbersHavePoints) {
  double value = 0.0;
  EXPECT_TRUE(ParseNumber("1.5", value) && value == 1.5);
  EXPECT_TRUE(ParseNumber("1.5e-400", value) && value == 0.0);
  EXPECT_FALSE(ParseNumber("1,5", value));
}

TEST_F(LocaleTest, FilesKeepTheirNumbers) {
  constexpr char kText[] = "x,y,z,nx,ny,nz\n1.5,-0.25,1e-400,0.125,1.0625e-30,12345678.5\n";
  absl::StatusOr<PointTable> table = LoadTable(dir_.Write("in.csv", kText));
  ASSERT_TRUE(table.ok()) << table.status();
  table->viewpoint = {0.1, 1e-30, 12345678.5};
  for (const char* name : {"out.csv", "out.xyz", "out.pcd", "out.ply", "out.npy"}) {
    ASSERT_TRUE(SaveTable(*table, dir_.File(name), {.ascii = std::string(name) != "out.npy"}).ok()) << name;
    const absl::StatusOr<PointTable> again = LoadTable(dir_.File(name));
    ASSERT_TRUE(again.ok()) << name << ": " << again.status();
    ASSERT_EQ(again->columns().size(), table->columns().size()) << name;
    for (size_t i = 0; i < table->columns().size(); ++i) {
      EXPECT_EQ(again->columns()[i].values, table->columns()[i].values) << name << ", column " << i;
    }
    if (std::string(name) == "out.pcd") {
      EXPECT_EQ(again->viewpoint, table->viewpoint);
    }
  }
}

}  // namespace
}  // namespace curv
