// Keeps outputs from replacing the files that they are made of.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace curv {

// The files that a command reads.
class KeptInputs {
 public:
  // Standard input, and files that are not there, are never replaced.
  explicit KeptInputs(const std::vector<std::string>& inputs);

  // Returns the name of the input that a file written as `output` would replace, whatever names they have; null if
  // there is none.
  const std::string* ReplacedBy(const std::string& output) const;
  // INVALID_ARGUMENT, naming both, if that is not null.
  absl::Status Check(const std::string& output) const;

 private:
  std::map<std::pair<dev_t, ino_t>, std::string> name_of_;  // by device and number of the file there
};

}  // namespace curv
