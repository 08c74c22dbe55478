#include "client/tiles/spill_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

constexpr uint64_t kLeastPiece = 16 << 10;
constexpr uint64_t kMostPiece = 4 << 20;

}  // namespace

absl::StatusOr<std::unique_ptr<SpillFile>> SpillFile::Create(const std::string& directory, size_t buckets,
                                                             uint64_t buffer_bytes) {
  std::string name = absl::StrCat(directory, "/spill-XXXXXX");
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) {
    return absl::DataLossError(absl::StrCat("cannot write in ", directory, ": ", std::strerror(errno)));
  }
  unlink(name.c_str());
  const uint64_t piece_bytes = std::clamp(buffer_bytes / buckets, kLeastPiece, kMostPiece);
  return std::unique_ptr<SpillFile>(new SpillFile(directory, descriptor, buckets, piece_bytes));
}

SpillFile::~SpillFile() { close(descriptor_); }

absl::Status SpillFile::Error(const char* action, int error_number) const {
  return absl::DataLossError(
      absl::StrCat("cannot ", action, " a temporary file in ", directory_, ": ", std::strerror(error_number)));
}

absl::Status SpillFile::MakeRoom(Bucket& bucket) {
  if (absl::Status status = Flush(bucket); !status.ok()) return status;
  bucket.buffer.resize(piece_bytes_);
  return absl::OkStatus();
}

absl::Status SpillFile::Flush(Bucket& bucket) {
  std::string_view bytes(bucket.buffer.data(), bucket.buffered);
  if (bytes.empty()) return absl::OkStatus();
  bucket.pieces.push_back({end_, bytes.size()});
  while (!bytes.empty()) {
    const ssize_t written = pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(end_));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Error("write", errno);
    bytes.remove_prefix(static_cast<size_t>(written));
    end_ += static_cast<uint64_t>(written);
  }
  bucket.buffered = 0;
  return absl::OkStatus();
}

absl::Status SpillFile::Finish() {
  for (Bucket& bucket : buckets_) {
    if (absl::Status status = Flush(bucket); !status.ok()) return status;
    bucket.buffer = std::string();
  }
  return absl::OkStatus();
}

void SpillFile::Drop(size_t bucket) {
  for (const Piece& piece : buckets_[bucket].pieces) {
    fallocate(descriptor_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(piece.at),
              static_cast<off_t>(piece.bytes));
  }
  buckets_[bucket].pieces.clear();
}

absl::Status SpillFile::Read(size_t bucket, const std::function<absl::Status(std::string_view records)>& take) const {
  std::string bytes;
  for (const Piece& piece : buckets_[bucket].pieces) {
    bytes.resize(piece.bytes);
    for (uint64_t size = 0; size < piece.bytes;) {
      const ssize_t got =
          pread(descriptor_, bytes.data() + size, piece.bytes - size, static_cast<off_t>(piece.at + size));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return Error("read", got < 0 ? errno : EIO);
      size += static_cast<uint64_t>(got);
    }
    if (absl::Status status = take(bytes); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace curv
