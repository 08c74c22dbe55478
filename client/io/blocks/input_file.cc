#include "client/io/blocks/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

absl::Status ReadError(const std::string& path, const std::string& reason) {
  return absl::InvalidArgumentError(absl::StrCat("cannot read ", path, ": ", reason));
}

// Reads until `out` is full or the file ends, and returns how many bytes came; -1 with errno if that fails.
ssize_t ReadSome(int descriptor, uint64_t at, size_t bytes, char* out) {
  size_t size = 0;
  while (size < bytes) {
    const ssize_t got = pread(descriptor, out + size, bytes - size, static_cast<off_t>(at + size));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    size += static_cast<size_t>(got);
  }
  return static_cast<ssize_t>(size);
}

}  // namespace

absl::StatusOr<InputFile> InputFile::Open(const std::string& path) {
  // A pipe, which is refused below, would have the open wait for a writer.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return ReadError(path, std::strerror(errno));
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0;
  InputFile file(
      path, descriptor,
      {static_cast<uint64_t>(status.st_size), int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec});
  if (!known) return ReadError(path, std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return ReadError(path, "it is no regular file, which could be read more than once");
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), stamp_(other.stamp_) {}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

absl::StatusOr<std::string> InputFile::Read(uint64_t at, size_t bytes) const {
  std::string result(bytes, '\0');
  const ssize_t got = ReadSome(descriptor_, at, bytes, result.data());
  if (got < 0) return ReadError(path_, std::strerror(errno));
  result.resize(static_cast<size_t>(got));
  return result;
}

absl::Status InputFile::ReadAll(uint64_t at, size_t bytes, char* out) const {
  const ssize_t got = ReadSome(descriptor_, at, bytes, out);
  if (got < 0) return ReadError(path_, std::strerror(errno));
  if (static_cast<size_t>(got) == bytes) return absl::OkStatus();
  return ReadError(path_, absl::StrCat("it ends at byte ", at + static_cast<uint64_t>(got), ", ",
                                       bytes - static_cast<size_t>(got), " bytes too early"));
}

}  // namespace curv
