#include "client/io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

absl::Status SystemError(std::string_view action, const std::string& path, int error_number) {
  return absl::InvalidArgumentError(
      absl::StrCat("cannot ", std::string(action), " ", path, ": ", std::strerror(error_number)));
}

std::string DirectoryOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

// What a symbolic link says, seen from where curv runs; nothing if it is none.
std::optional<std::string> LinkTarget(const std::string& path) {
  std::string target(PATH_MAX, '\0');
  const ssize_t size = readlink(path.c_str(), target.data(), target.size());
  if (size <= 0) return std::nullopt;
  target.resize(static_cast<size_t>(size));
  return target.front() == '/' ? target
                               : absl::StrCat(DirectoryOf(path), path.rfind('/') == path.npos ? "/" : "", target);
}

// Where symbolic links lead, so that a link to a file stays a link, also to one that is yet to be made.
absl::StatusOr<std::string> Resolved(const std::string& path) {
  constexpr int kMostLinks = 40;  // as in the system
  if (char* resolved = realpath(path.c_str(), nullptr); resolved != nullptr) {
    std::string result = resolved;
    std::free(resolved);
    return result;
  }
  // What is open may have a name that leads nowhere, as that of a pipe.
  struct stat existing {};
  if (stat(path.c_str(), &existing) == 0) return path;
  std::string at = path;
  for (int links = 0; links <= kMostLinks; ++links) {
    const std::optional<std::string> target = LinkTarget(at);
    if (!target.has_value()) return at;
    at = *target;
  }
  return SystemError("write", path, ELOOP);
}

mode_t DefaultMode() {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

}  // namespace

absl::StatusOr<AtomicFile> AtomicFile::Create(const std::string& path) {
  if (path == "-") {
    const int descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (descriptor < 0) return SystemError("write", "standard output", errno);
    return AtomicFile("standard output", "", descriptor);
  }
  const absl::StatusOr<std::string> resolved = Resolved(path);
  if (!resolved.ok()) return resolved.status();
  const std::string& target = *resolved;
  struct stat existing {};
  const bool exists = stat(target.c_str(), &existing) == 0;
  if (exists && S_ISDIR(existing.st_mode)) return SystemError("write", path, EISDIR);
  if (exists && !S_ISREG(existing.st_mode)) {
    const int descriptor = open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) return SystemError("write", path, errno);
    return AtomicFile(path, "", descriptor);
  }
  std::string temporary = absl::StrCat(target, ".part-XXXXXX");
  const int descriptor = mkostemp(temporary.data(), O_CLOEXEC);
  if (descriptor < 0) return SystemError("write", path, errno);
  fchmod(descriptor, exists ? existing.st_mode & 07777 : DefaultMode());
  return AtomicFile(target, temporary, descriptor);
}

absl::Status AtomicFile::Check(const std::string& path) {
  if (path == "-" || !IsWrittenDirectly(path)) return Create(path).status();
  return access(path.c_str(), W_OK) == 0 ? absl::OkStatus() : SystemError("write", path, errno);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, std::string())),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

absl::Status AtomicFile::Error(std::string_view action, int error_number) const {
  return SystemError(action, target_, error_number);
}

absl::Status AtomicFile::Append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Error("write", errno);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status AtomicFile::Commit() {
  if (!temporary_.empty() && fsync(descriptor_) != 0) return Error("write", errno);
  // Network file systems report a full disk here.
  if (close(std::exchange(descriptor_, -1)) != 0) return Error("write", errno);
  if (temporary_.empty()) return absl::OkStatus();
  if (rename(temporary_.c_str(), target_.c_str()) != 0) return Error("replace", errno);
  temporary_.clear();
  const int directory = open(DirectoryOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    fsync(directory);
    close(directory);
  }
  return absl::OkStatus();
}

bool IsWrittenDirectly(const std::string& path) {
  if (path == "-") return true;
  struct stat existing {};
  return stat(path.c_str(), &existing) == 0 && !S_ISREG(existing.st_mode) && !S_ISDIR(existing.st_mode);
}

}  // namespace curv
