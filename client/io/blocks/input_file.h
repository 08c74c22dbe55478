// A file that is open for reading.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace curv {

// What tells whether a file has changed since it was looked at.
struct FileStamp {
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  // since 1970

  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

// Const methods are thread-safe.
class InputFile {
 public:
  // INVALID_ARGUMENT naming the path and the system's reason if it cannot be read, or is no regular file.
  static absl::StatusOr<InputFile> Open(const std::string& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  ~InputFile();

  const std::string& path() const { return path_; }
  const FileStamp& stamp() const { return stamp_; }

  // Reads the bytes from `at` on, up to `bytes` of them; fewer at the end of the file. INVALID_ARGUMENT as above.
  absl::StatusOr<std::string> Read(uint64_t at, size_t bytes) const;
  // Reads exactly so many; INVALID_ARGUMENT also if the file ends before.
  absl::Status ReadAll(uint64_t at, size_t bytes, char* out) const;

 private:
  InputFile(std::string path, int descriptor, FileStamp stamp)
      : path_(std::move(path)), descriptor_(descriptor), stamp_(stamp) {}

  std::string path_;
  int descriptor_;  // -1 once moved from
  FileStamp stamp_;
};

}  // namespace curv
