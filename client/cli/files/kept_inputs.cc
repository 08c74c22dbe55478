#include "client/cli/files/kept_inputs.h"

#include <sys/stat.h>

#include <optional>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

// What all names of one file have in common; none if there is no such file, or if it holds nothing that writing
// could destroy, as a pipe or a device.
std::optional<std::pair<dev_t, ino_t>> IdentityOf(const std::string& path) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0 || !S_ISREG(file.st_mode)) return std::nullopt;
  return std::pair(file.st_dev, file.st_ino);
}

}  // namespace

KeptInputs::KeptInputs(const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    if (const auto identity = IdentityOf(input)) name_of_.emplace(*identity, input);
  }
}

const std::string* KeptInputs::ReplacedBy(const std::string& output) const {
  const auto identity = IdentityOf(output);
  if (!identity.has_value()) return nullptr;
  const auto replaced = name_of_.find(*identity);
  return replaced == name_of_.end() ? nullptr : &replaced->second;
}

absl::Status KeptInputs::Check(const std::string& output) const {
  const std::string* replaced = ReplacedBy(output);
  if (replaced == nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("--output: ", output, " would replace the input ", *replaced, ": name another file"));
}

}  // namespace curv
