// Reads a file, and notices when it has changed.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace curvd {

// Most bytes of such a file; certificates and lists are far smaller.
inline constexpr size_t kMaxWatchedFileBytes = 16 << 20;

// Knows a file's last state by device, inode, size and times of change, following symbolic links: a file that was
// rewritten, replaced, or whose link was turned (as Kubernetes does with secrets) counts as changed. Not thread-safe.
class WatchedFile {
 public:
  explicit WatchedFile(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  // Whether the file is not as it was when this was called last, or has never been looked at. A file that cannot be
  // found counts as changed once.
  bool Changed();
  // All bytes of the file. UNAVAILABLE, naming the path, if it cannot be read, is no regular file (a pipe
  // could keep the caller waiting for ever), or is larger than kMaxWatchedFileBytes.
  absl::StatusOr<std::string> Read() const;

 private:
  struct State {
    bool found = false;
    dev_t device = 0;
    ino_t inode = 0;
    int64_t size = 0;
    int64_t modified_ns = 0;
    int64_t changed_ns = 0;
    bool operator==(const State&) const = default;
  };

  std::string path_;
  bool looked_at_ = false;
  State state_;
};

}  // namespace curvd
