#include "client/io/table_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>

#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PointTable Sample() {
  PointTable table;
  table.Set({"x", std::vector<double>{4500000.123456789, -0.0, 1e-300}});
  table.Set({"k1", std::vector<float>{0.1f, std::numeric_limits<float>::quiet_NaN(), -INFINITY}});
  table.Set({"status", std::vector<uint8_t>{1, 4, 8}});
  table.Set({"a name,\"b\"", std::vector<int16_t>{-1, 0, 32767}});
  table.Set({"u", std::vector<uint32_t>{0, 1, 4294967295}});
  return table;
}

// Equal to the last bit; NaN equals NaN.
void ExpectSame(const Column& a, const Column& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(a.At(i) == b.At(i) || (std::isnan(a.At(i)) && std::isnan(b.At(i)))) << a.name << " " << i;
  }
}

TEST(TableFileTest, PlyComesBackInItsTypes) {
  const TempDir dir;
  const PointTable table = Sample();
  ASSERT_TRUE(SaveTable(table, dir.File("t.PLY")).ok());
  const absl::StatusOr<PointTable> read = LoadTable(dir.File("t.PLY"));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->columns().size(), table.columns().size());
  EXPECT_EQ(read->columns()[3].name, "a_name__b_");
  for (size_t c = 0; c < table.columns().size(); ++c) {
    EXPECT_EQ(read->columns()[c].kind(), table.columns()[c].kind());
    ExpectSame(table.columns()[c], read->columns()[c]);
  }
  EXPECT_THAT(dir.Read("t.PLY"), HasSubstr("comment status 1=ok 2=too_few_neighbors"));
  EXPECT_THAT(dir.Read("t.PLY"), HasSubstr(" 7=opposed_normals 8=outlier\n"));
}

TEST(TableFileTest, CsvComesBackInItsDigits) {
  const TempDir dir;
  const PointTable table = Sample();
  ASSERT_TRUE(SaveTable(table, dir.File("t.csv")).ok());
  EXPECT_EQ(dir.Read("t.csv"),
            "x,k1,status,a_name__b_,u\n"
            "4500000.123456789,0.1,ok,-1,0\n"
            "-0,nan,invalid_input,0,1\n"
            "1e-300,-inf,outlier,32767,4294967295\n");
  const absl::StatusOr<PointTable> read = LoadTable(dir.File("t.csv"));
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(table.columns()[0], read->columns()[0]);
  ExpectSame(table.columns()[2], read->columns()[2]);
  EXPECT_EQ(static_cast<float>(read->columns()[1].At(0)), 0.1f);
}

TEST(TableFileTest, WritesManyBlocks) {
  const TempDir dir;
  PointTable table;
  std::vector<double> values(10'001);
  for (size_t i = 0; i < values.size(); ++i) values[i] = std::sqrt(static_cast<double>(i));
  table.Set({"x", values});
  table.Set({"flag", std::vector<uint8_t>(values.size(), 9)});
  for (const char* name : {"t.ply", "t.csv"}) {
    ASSERT_TRUE(SaveTable(table, dir.File(name)).ok());
    const absl::StatusOr<PointTable> read = LoadTable(dir.File(name));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(Values(*read, "x"), values) << name;
  }
}

TEST(TableFileTest, NamesTheFileInErrors) {
  const TempDir dir;
  EXPECT_THAT(LoadTable(dir.File("none.ply")).status().message(), HasSubstr("none.ply: No such file"));
  EXPECT_THAT(LoadTable(dir.Write("scan.doc", "")).status().message(), HasSubstr("\".doc\" is not known"));
  const std::string nameless(LoadTable(dir.Write("scan", "")).status().message());
  EXPECT_THAT(nameless, HasSubstr("scan: there is no extension: it must be one of"));
  EXPECT_THAT(nameless, HasSubstr("; or say --format=ply"));
  EXPECT_THAT(LoadTable(dir.File("nowhere")).status().message(), HasSubstr("cannot read"));
  EXPECT_THAT(LoadTable(dir.File("nowhere")).status().message(), HasSubstr("nowhere: No such file"));
  const std::string damaged = dir.Write("bad.ply", "plx\n");
  EXPECT_THAT(LoadTable(damaged).status().message(), HasSubstr("bad.ply: line 1"));
  std::filesystem::create_directory(dir.File("dir.ply"));
  EXPECT_THAT(LoadTable(dir.File("dir.ply")).status().message(), HasSubstr("is a directory: name the files in it"));
  EXPECT_THAT(SaveTable(Sample(), dir.File("t.obj")).message(),
              HasSubstr("\".obj\" cannot be written: it must be one of .ply .pcd .xyz .csv .las .npy .npz"));
}

// A file with holes takes no room on the disk; some devices never end.
TEST(TableFileTest, RefusesFilesLargerThanTheMemory) {
  const TempDir dir;
  const std::string path = dir.Write("huge.ply", "ply");
  ASSERT_EQ(truncate(path.c_str(), off_t{1} << 42), 0);
  EXPECT_THAT(std::string(LoadTable(path).status().message()),
              AllOf(HasSubstr("huge.ply: it has more than"), HasSubstr("bytes of memory that curv may use")));
}

TEST(TableFileTest, ReadsEveryExtension) {
  const TempDir dir;
  for (const char* name : {"a.xyz", "a.pts", "a.xyzn", "a.TXT", "a.asc"}) {
    const absl::StatusOr<PointTable> table = LoadTable(dir.Write(name, "1 2 3 0 0 1\n"));
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "y"), ElementsAre(2)) << name;
  }
  EXPECT_TRUE(LoadTable(dir.Write("a.obj", "v 1 2 3\n")).ok());
  EXPECT_TRUE(LoadTable(dir.Write("a.pcd", "FIELDS x\nSIZE 4\nTYPE F\nPOINTS 1\nDATA ascii\n7\n")).ok());
}

// A reader may take such a file, whose header can be right. Nobody who names it as an input wants an empty result.
TEST(TableFileTest, RefusesFilesWithoutPoints) {
  const TempDir dir;
  const auto message = [&dir](const char* name, const char* bytes) {
    return std::string(LoadTable(dir.Write(name, bytes)).status().message());
  };
  for (const char* name : {"a.xyz", "a.pts", "a.xyzn", "a.txt", "a.asc"}) {
    EXPECT_THAT(message(name, ""), HasSubstr(std::string(name) + ": the file holds no points, it is empty: expected "
                                                                 "lines of x y z nx ny nz"));
    EXPECT_THAT(message(name, "# x y z\n\n"), HasSubstr("the file holds no points: expected lines")) << name;
    EXPECT_THAT(message(name, "0\n"), HasSubstr("the file holds no points: expected lines")) << name;
  }
  EXPECT_THAT(message("a.obj", ""), HasSubstr("a.obj: the file holds no points, it is empty: expected v lines"));
  EXPECT_THAT(message("a.obj", "# v 1 2 3\n"), HasSubstr("the file holds no points: expected v lines"));
  EXPECT_THAT(message("a.csv", ""), HasSubstr("a.csv: line 1: the file is empty"));
  EXPECT_THAT(message("a.csv", "x,y,z,nx,ny,nz\n"), HasSubstr("holds no points: expected lines of values after the"));
  EXPECT_THAT(message("a.ply", ""), HasSubstr("a.ply: line 1: expected the word ply"));
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string ply =
        std::string("ply\nformat ") + format + " 1.0\nelement vertex 0\nproperty float x\nelement face 0\nend_header\n";
    EXPECT_THAT(message("a.ply", ply.c_str()), HasSubstr("holds no points: expected rows of the element vertex"));
  }
  EXPECT_THAT(message("a.pcd", ""), HasSubstr("a.pcd: line 1: the header of a PCD file does not end"));
  for (const char* encoding : {"ascii", "binary"}) {
    const std::string pcd = std::string("FIELDS x\nSIZE 4\nTYPE F\nPOINTS 0\nDATA ") + encoding + "\n";
    EXPECT_THAT(message("a.pcd", pcd.c_str()), HasSubstr("holds no points: expected POINTS of 1 or more"));
  }
}

// A limit on the size of files fails in the middle of writing, as a full disk does.
TEST(TableFileTest, AFullDiskLeavesTheOldFile) {
  const TempDir dir;
  dir.Write("t.ply", "old");
  PointTable table;
  table.Set({"x", std::vector<double>(100'000)});
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 300'000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const absl::Status status = SaveTable(table, dir.File("t.ply"));
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(status.message(), HasSubstr("t.ply: File too large"));
  EXPECT_EQ(dir.Read("t.ply"), "old");
  EXPECT_EQ(dir.FileCount(), 1u);
}

TEST(TableFileTest, ReportsAFullDevice) {
  const TempDir dir;
  std::filesystem::create_symlink("/dev/full", dir.File("full.ply"));
  EXPECT_THAT(SaveTable(Sample(), dir.File("full.ply")).message(), HasSubstr("No space left"));
}

TEST(TableFileTest, RefusesFormsThatAFormatLacks) {
  const TempDir dir;
  for (const char* name : {"a.las", "a.npy", "a.npz", "a.las.gz"}) {
    const absl::Status status = CheckWritable(dir.File(name), {.ascii = true});
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(status.message(), HasSubstr(" has no form of text: the output must be .ply, .pcd, .xyz or .csv"));
  }
  EXPECT_THAT(CheckWritable("-", {.ascii = true, .format = "npz"}).message(),
              HasSubstr("standard output: --ascii: .npz has no form of text"));
  for (const char* name : {"a.ply", "a.pcd", "a.xyz", "a.csv", "a.csv.gz"}) {
    EXPECT_TRUE(CheckWritable(dir.File(name), {.ascii = true}).ok()) << name;
  }
}

TEST(TableFileTest, CheckWritableLeavesNoTrace) {
  const TempDir dir;
  EXPECT_TRUE(CheckWritable(dir.File("new.ply")).ok());
  EXPECT_EQ(dir.FileCount(), 0u);
  EXPECT_FALSE(CheckWritable(dir.File("new.doc")).ok());
  EXPECT_FALSE(CheckWritable(dir.File("no/new.ply")).ok());
}

}  // namespace
}  // namespace curv
