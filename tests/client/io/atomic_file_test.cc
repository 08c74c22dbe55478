#include "client/io/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;

TEST(AtomicFileTest, AppearsWhole) {
  const TempDir dir;
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(dir.File("out"));
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_TRUE(file->Append("hello ").ok());
  EXPECT_FALSE(dir.Has("out"));
  ASSERT_TRUE(file->Append("world").ok());
  ASSERT_TRUE(file->Commit().ok());
  EXPECT_EQ(dir.Read("out"), "hello world");
  EXPECT_EQ(dir.FileCount(), 1u);
}

TEST(AtomicFileTest, LeavesTheOldFileUnlessCommitted) {
  const TempDir dir;
  dir.Write("out", "old");
  {
    absl::StatusOr<AtomicFile> file = AtomicFile::Create(dir.File("out"));
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_TRUE(file->Append("new").ok());
  }
  EXPECT_EQ(dir.Read("out"), "old");
  EXPECT_EQ(dir.FileCount(), 1u);
}

TEST(AtomicFileTest, KeepsTheModeOfTheOldFile) {
  const TempDir dir;
  const std::string path = dir.Write("out", "old");
  chmod(path.c_str(), 0640);
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  ASSERT_TRUE(file.ok() && file->Commit().ok());
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFileTest, NewFilesFollowTheMask) {
  const TempDir dir;
  const mode_t before = umask(027);
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(dir.File("out"));
  umask(before);
  ASSERT_TRUE(file.ok() && file->Commit().ok());
  struct stat status {};
  ASSERT_EQ(stat(dir.File("out").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFileTest, FollowsLinks) {
  const TempDir dir;
  dir.Write("real", "old");
  std::filesystem::create_symlink("real", dir.File("link"));
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(dir.File("link"));
  ASSERT_TRUE(file.ok() && file->Append("new").ok() && file->Commit().ok());
  EXPECT_TRUE(std::filesystem::is_symlink(dir.File("link")));
  EXPECT_EQ(dir.Read("real"), "new");
}

TEST(AtomicFileTest, MakesTheFileThatALinkLeadsTo) {
  namespace fs = std::filesystem;
  const TempDir dir;
  fs::create_directory(dir.File("sub"));
  fs::create_symlink("second", dir.File("sub/first"));
  fs::create_symlink(dir.File("real"), dir.File("sub/second"));
  const fs::path before = fs::current_path();
  for (const char* path : {"sub/first", "first"}) {
    fs::current_path(path == std::string("first") ? dir.File("sub") : dir.File(""));
    absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
    EXPECT_TRUE(file.ok() && file->Append("new").ok() && file->Commit().ok());
    EXPECT_EQ(dir.Read("real"), "new") << path;
    EXPECT_TRUE(fs::is_symlink(dir.File("sub/first")) && fs::is_symlink(dir.File("sub/second")));
    fs::remove(dir.File("real"));
  }
  fs::current_path(before);
  fs::create_symlink(dir.File("no/file"), dir.File("nowhere"));
  EXPECT_THAT(AtomicFile::Create(dir.File("nowhere")).status().message(), HasSubstr("nowhere: No such file"));
  fs::create_symlink("circle", dir.File("circle"));
  EXPECT_THAT(AtomicFile::Create(dir.File("circle")).status().message(), HasSubstr("symbolic links"));
  EXPECT_TRUE(fs::is_symlink(dir.File("circle")));
}

TEST(AtomicFileTest, NamesPathAndReason) {
  const TempDir dir;
  EXPECT_THAT(AtomicFile::Create(dir.File("missing/out")).status().message(),
              HasSubstr("missing/out: No such file or directory"));
  EXPECT_THAT(AtomicFile::Create(dir.File("")).status().message(), HasSubstr("Is a directory"));
}

// Who opens a pipe waits for its reader, and the reader of one that is closed again gets nothing.
TEST(AtomicFileTest, ChecksAPipeWithoutOpeningIt) {
  const TempDir dir;
  const std::string pipe = dir.File("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(AtomicFile::Check(pipe).ok());
  EXPECT_TRUE(IsWrittenDirectly(pipe));
  EXPECT_TRUE(AtomicFile::Check("/dev/full").ok());
  EXPECT_TRUE(AtomicFile::Check("-").ok());
  EXPECT_TRUE(AtomicFile::Check(dir.File("new")).ok());
  EXPECT_FALSE(IsWrittenDirectly(dir.File("new")));
  EXPECT_FALSE(IsWrittenDirectly(dir.Write("old", "")));
  EXPECT_THAT(AtomicFile::Check(dir.File("")).message(), HasSubstr("Is a directory"));
  EXPECT_EQ(dir.FileCount(), 2u);
}

TEST(AtomicFileTest, WritesToDevicesDirectlyAndReportsAFullOne) {
  absl::StatusOr<AtomicFile> file = AtomicFile::Create("/dev/full");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->Append("x").message(), HasSubstr("No space left on device"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

}  // namespace
}  // namespace curv
