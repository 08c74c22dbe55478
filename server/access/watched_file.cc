#include "server/access/watched_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

int64_t Nanoseconds(const timespec& time) { return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }

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
  errno = 0;
  std::ifstream file(path_, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0) {
    return absl::UnavailableError(absl::StrCat("cannot read ", path_, ": ", std::strerror(errno == 0 ? EIO : errno)));
  }
  if (static_cast<uint64_t>(size) > kMaxWatchedFileBytes) {
    return absl::UnavailableError(
        absl::StrCat(path_, " has ", size, " bytes; it must have at most ", kMaxWatchedFileBytes));
  }
  std::string bytes(static_cast<size_t>(size), '\0');
  file.seekg(0);
  file.read(bytes.data(), size);
  bytes.resize(static_cast<size_t>(file.gcount()));
  return bytes;
}

}  // namespace curvd
