// Remembers which files of a directory were finished, and with which options.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"

namespace curv {

inline constexpr char kFinishedFiles[] = ".curv-finished.jsonl";

// Not thread-safe; several may write to one directory at a time.
class FinishedFiles {
 public:
  // Reads what earlier runs have noted in directory/.curv-finished.jsonl, a JSON object a line: the output's name, its
  // size and the options; where one of these is not UTF-8, its bytes are in hexadecimal digits beside it. Lines that
  // are cut off or damaged count as not written.
  FinishedFiles(const std::string& directory, const std::string& options);

  // Returns whether the output was finished with these options, has the size that it had then, and is newer than the
  // input. REQUIRES: the output lies in the directory.
  bool Has(const std::string& input, const std::string& output) const;

  // Notes that the output is finished, on disk too. INVALID_ARGUMENT naming the file and the system's reason if that
  // fails: the output is then made again the next time.
  absl::Status Add(const std::string& output);

 private:
  struct Entry {
    std::string options;
    uint64_t bytes;
  };

  std::string path_;
  std::string options_;
  std::map<std::string, Entry> entries_;  // by the output's name
};

}  // namespace curv
