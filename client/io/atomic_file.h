// Writes a file whole or not at all.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/byte_sink.h"

namespace curv {

// Writes to a temporary file beside the target and renames it at the end: whoever looks at the target sees the old file
// or the whole new one, also after a crash. A target that exists and is no regular file (a device, a pipe) is written
// to directly, since it cannot be replaced; so is standard output. Not thread-safe.
class AtomicFile : public ByteSink {
 public:
  // INVALID_ARGUMENT naming the path and the system's reason if no file can be created there. "-" is standard output.
  static absl::StatusOr<AtomicFile> Create(const std::string& path);

  // The same errors, without a trace. What is written to directly is not opened, though: to open a pipe waits for its
  // reader, who would read an empty stream once it is closed again.
  static absl::Status Check(const std::string& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  // Removes what was written, unless Commit succeeded.
  ~AtomicFile() override;

  // INVALID_ARGUMENT naming the path and the system's reason (disk full, say). REQUIRES: no Append failed before.
  absl::Status Append(std::string_view bytes) override;

  // Makes the file appear, its bytes safely on disk. The same errors; the target is then as it was before.
  // REQUIRES: called once, after the last Append, none of which failed.
  absl::Status Commit();

 private:
  AtomicFile(std::string target, std::string temporary, int descriptor)
      : target_(std::move(target)), temporary_(std::move(temporary)), descriptor_(descriptor) {}
  absl::Status Error(std::string_view action, int error_number) const;

  std::string target_;
  std::string temporary_;  // empty if the target is written to directly
  int descriptor_;         // -1 once closed or moved from
};

// Returns whether a target of that name is written to directly: standard output, or what exists and is neither a
// regular file nor a directory.
bool IsWrittenDirectly(const std::string& path);

}  // namespace curv
