#include "client/cli/files/finished_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/cli/json.h"

namespace curv {
namespace {

namespace fs = std::filesystem;

std::string NameOf(const std::string& output) { return fs::path(output).filename().string(); }

// JSON has no bytes that are not UTF-8, which names of files can hold: such text stands beside it as digits, so that
// two texts never become one.
std::string DigitsName(const char* field) { return absl::StrCat(field, "_hex"); }

void AddText(const char* field, const std::string& text, nlohmann::ordered_json& entry) {
  entry[field] = text;
  const bool is_utf8 = nlohmann::json::parse(ToJsonLine(text)) == nlohmann::json(text);
  if (!is_utf8) entry[DigitsName(field)] = absl::BytesToHexString(text);
}

// None if the entry has no such field.
std::optional<std::string> TextOf(const nlohmann::json& entry, const char* field) {
  const auto digits = entry.find(DigitsName(field)), text = entry.find(field);
  if (digits != entry.end()) {
    return digits->is_string() ? std::optional(absl::HexStringToBytes(digits->get<std::string>())) : std::nullopt;
  }
  return text != entry.end() && text->is_string() ? std::optional(text->get<std::string>()) : std::nullopt;
}

std::optional<uint64_t> BytesOf(const std::string& path) {
  std::error_code error;
  const uint64_t bytes = fs::file_size(path, error);
  return error ? std::nullopt : std::optional(bytes);
}

absl::Status AppendLine(const std::string& line, const std::string& path) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  // One write, so that lines of several programs do not mix.
  bool written = descriptor >= 0 && write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  written = written && fsync(descriptor) == 0;
  const int error = errno;
  if (descriptor >= 0) close(descriptor);
  if (written) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("cannot write ", path, ": ", std::strerror(error)));
}

}  // namespace

FinishedFiles::FinishedFiles(const std::string& directory, const std::string& options)
    : path_((fs::path(directory) / kFinishedFiles).string()), options_(options) {
  std::ifstream file(path_);
  for (std::string line; std::getline(file, line);) {
    const auto entry = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!entry.is_object() || !entry.contains("bytes") || !entry["bytes"].is_number_unsigned()) continue;
    const std::optional<std::string> output = TextOf(entry, "output"), options_then = TextOf(entry, "options");
    if (output.has_value() && options_then.has_value()) entries_[*output] = {*options_then, entry["bytes"]};
  }
}

bool FinishedFiles::Has(const std::string& input, const std::string& output) const {
  const auto found = entries_.find(NameOf(output));
  if (found == entries_.end() || found->second.options != options_ || found->second.bytes != BytesOf(output)) {
    return false;
  }
  std::error_code no_input, no_output;
  const fs::file_time_type input_time = fs::last_write_time(input, no_input);
  const fs::file_time_type output_time = fs::last_write_time(output, no_output);
  return !no_input && !no_output && output_time > input_time;
}

absl::Status FinishedFiles::Add(const std::string& output) {
  const std::optional<uint64_t> bytes = BytesOf(output);
  if (!bytes.has_value()) return absl::InvalidArgumentError(absl::StrCat("cannot read the size of ", output));
  const std::string name = NameOf(output);
  // The line of a run that was cut off may have no end.
  nlohmann::ordered_json entry;
  AddText("output", name, entry);
  entry["bytes"] = *bytes;
  AddText("options", options_, entry);
  const std::string line = absl::StrCat("\n", ToJsonLine(entry));
  if (absl::Status status = AppendLine(line, path_); !status.ok()) return status;
  entries_[name] = {options_, *bytes};
  return absl::OkStatus();
}

}  // namespace curv
