#include "server/access/watched_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

int64_t Nanoseconds(const timespec& time) { return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }

// All bytes of the regular file of `size` bytes that `fd` leads to.
absl::StatusOr<std::string> ReadAll(int fd, size_t size) {
  std::string bytes(size, '\0');
  size_t length = 0;
  while (length < size) {
    const ssize_t count = read(fd, bytes.data() + length, size - length);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return absl::UnavailableError(std::strerror(errno));
    if (count == 0) break;  // somebody has just made it shorter
    length += static_cast<size_t>(count);
  }
  bytes.resize(length);
  return bytes;
}

absl::StatusOr<std::string> ReadRegularFile(int fd) {
  struct stat info = {};
  if (fstat(fd, &info) != 0) return absl::UnavailableError(std::strerror(errno));
  if (!S_ISREG(info.st_mode)) return absl::UnavailableError("it is no regular file");
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > kMaxWatchedFileBytes) {
    return absl::UnavailableError(
        absl::StrCat("it has ", size, " bytes, and must have at most ", kMaxWatchedFileBytes));
  }
  return ReadAll(fd, size);
}

}  // namespace

bool WatchedFile::Changed() {
  State now;
  struct stat info = {};
  if (stat(path_.c_str(), &info) == 0) {
    now = {true, info.st_dev, info.st_ino, info.st_size, Nanoseconds(info.st_mtim), Nanoseconds(info.st_ctim)};
  }
  const bool changed = !looked_at_ || now != state_;
  looked_at_ = true;
  state_ = now;
  return changed;
}

absl::StatusOr<std::string> WatchedFile::Read() const {
  // Without O_NONBLOCK the opening of a pipe would wait until somebody writes to it.
  const int fd = open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  absl::StatusOr<std::string> bytes = fd < 0 ? absl::UnavailableError(std::strerror(errno)) : ReadRegularFile(fd);
  if (fd >= 0) close(fd);
  if (bytes.ok()) return bytes;
  return absl::UnavailableError(absl::StrCat("cannot read ", path_, ": ", bytes.status().message()));
}

}  // namespace curvd
