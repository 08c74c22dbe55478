// Sorts more bytes than fit into memory into buckets, on disk.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace curv {

// A file without a name, in which each bucket is a chain of pieces that are written one after the other: disks see
// large writes, and later large reads. The file is gone when the process is. Not thread-safe.
class SpillFile {
 public:
  // A file in `directory`, with `buckets` buckets, which together have `buffer_bytes` of memory. DATA_LOSS naming the
  // directory and the system's reason if there can be none. REQUIRES: buckets is 1 or more.
  static absl::StatusOr<std::unique_ptr<SpillFile>> Create(const std::string& directory, size_t buckets,
                                                           uint64_t buffer_bytes);
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;
  ~SpillFile();

  // Appends a record of `bytes` bytes to a bucket, and sets `record` to where the caller writes it before the next
  // call. DATA_LOSS saying why something cannot be written. REQUIRES: 1 <= bytes <= 16384.
  absl::Status Extend(size_t bucket, size_t bytes, char*& record) {
    Bucket& to = buckets_[bucket];
    if (to.buffered + bytes > to.buffer.size()) {
      if (absl::Status status = MakeRoom(to); !status.ok()) return status;
    }
    record = to.buffer.data() + to.buffered;
    to.buffered += bytes;
    return absl::OkStatus();
  }
  // Writes what is left in memory, and gives the memory back. Called once, after the last Extend.
  absl::Status Finish();

  // Gives a bucket's place on disk back, where the file system can. REQUIRES: the bucket is not read again.
  void Drop(size_t bucket);
  // Hands out a bucket's bytes in the order in which they came, whole records at a time. Errors are those of `take`, or
  // DATA_LOSS. REQUIRES: Finish was called.
  absl::Status Read(size_t bucket, const std::function<absl::Status(std::string_view records)>& take) const;

 private:
  struct Piece {
    uint64_t at;
    uint64_t bytes;
  };
  struct Bucket {
    std::string buffer;  // as long as a piece, once there is a record
    size_t buffered = 0;
    std::vector<Piece> pieces;
  };

  SpillFile(std::string directory, int descriptor, size_t buckets, size_t piece_bytes)
      : directory_(std::move(directory)), descriptor_(descriptor), piece_bytes_(piece_bytes), buckets_(buckets) {}
  absl::Status Error(const char* action, int error_number) const;
  absl::Status MakeRoom(Bucket& bucket);
  absl::Status Flush(Bucket& bucket);

  const std::string directory_;
  const int descriptor_;
  const size_t piece_bytes_;
  uint64_t end_ = 0;
  std::vector<Bucket> buckets_;
};

}  // namespace curv
