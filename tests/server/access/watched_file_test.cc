#include "server/access/watched_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/client/temp_dir.h"

namespace curvd {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(WatchedFileTest, ChangesWhenItIsWrittenReplacedOrRemoved) {
  const curv::TempDir dir;
  WatchedFile file(dir.Write("tokens", "a"));
  EXPECT_TRUE(file.Changed());
  EXPECT_FALSE(file.Changed());
  dir.Write("tokens", "ab");
  EXPECT_TRUE(file.Changed());
  EXPECT_EQ(*file.Read(), "ab");
  dir.Write("new", "cd");
  std::filesystem::rename(dir.File("new"), dir.File("tokens"));
  EXPECT_TRUE(file.Changed());
  EXPECT_EQ(*file.Read(), "cd");
  std::filesystem::remove(dir.File("tokens"));
  EXPECT_TRUE(file.Changed());
  EXPECT_FALSE(file.Changed());
}

TEST(WatchedFileTest, RefusesPipesAndFoldersInsteadOfWaitingForThem) {
  const curv::TempDir dir;
  ASSERT_EQ(mkfifo(dir.File("pipe").c_str(), 0600), 0);
  std::filesystem::create_directory(dir.File("folder"));
  for (const char* name : {"pipe", "folder"}) {
    const auto bytes = WatchedFile(dir.File(name)).Read();
    EXPECT_EQ(bytes.status().code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(std::string(bytes.status().message()), AllOf(HasSubstr(name), HasSubstr("no regular file")));
  }
}

TEST(WatchedFileTest, FollowsTheLinksThatKubernetesTurns) {
  const curv::TempDir dir;
  for (const char* version : {"v1", "v2"}) {
    std::filesystem::create_directory(dir.File(version));
    dir.Write(std::string(version) + "/tokens", version);
  }
  std::filesystem::create_symlink("v1", dir.File("data"));
  std::filesystem::create_symlink("data/tokens", dir.File("tokens"));
  WatchedFile file(dir.File("tokens"));
  EXPECT_TRUE(file.Changed());
  std::filesystem::create_symlink("v2", dir.File("data_new"));
  std::filesystem::rename(dir.File("data_new"), dir.File("data"));
  EXPECT_TRUE(file.Changed());
  EXPECT_EQ(*file.Read(), "v2");
}

TEST(WatchedFileTest, NamesAFileThatCannotBeRead) {
  const curv::TempDir dir;
  const WatchedFile missing(dir.File("missing"));
  EXPECT_EQ(missing.Read().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(missing.Read().status().message()), HasSubstr(dir.File("missing")));
  const WatchedFile large(dir.Write("large", std::string(kMaxWatchedFileBytes + 1, 'x')));
  EXPECT_THAT(std::string(large.Read().status().message()), HasSubstr("16777216"));
}

}  // namespace
}  // namespace curvd
