#include "client/cli/files/batch.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/command.h"
#include "client/cli/files/finished_files.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

namespace fs = std::filesystem;

std::string LowerExtension(const fs::path& path) { return absl::AsciiStrToLower(path.extension().string()); }

std::string OutputName(const std::string& input, const std::string& format) {
  fs::path name = fs::path(input).filename();
  if (LowerExtension(name) == ".gz") name.replace_extension();
  if (!format.empty()) return name.replace_extension(format).string();
  if (!IsWritable(name.string())) name.replace_extension("ply");
  return name.string();
}

// Counts what became of the files, and tells it.
class BatchReport {
 public:
  BatchReport(size_t files, bool json) : files_(files), json_(json), start_(absl::Now()) {}

  void Skipped(const BatchFile& file) {
    ++skipped_;
    if (json_) {
      std::fputs(ToJsonLine({{"input", file.input}, {"output", file.output}, {"skipped", true}}).c_str(), stdout);
    } else {
      std::printf("%s: skipped, %s is finished\n", Visible(file.input).c_str(), Visible(file.output).c_str());
    }
    std::fflush(stdout);
  }

  void Done(const BatchFile& file, const BatchOutcome& outcome) {
    ++done_;
    points_ += outcome.points;
    if (json_) {
      std::fputs(outcome.summary.c_str(), stdout);
    } else {
      std::printf("%s: %s -> %s\n", Visible(file.input).c_str(), outcome.summary.c_str(), Visible(file.output).c_str());
    }
    std::fflush(stdout);
  }

  // REQUIRES: whoever tried has told why, with the file's name.
  void Failed(const BatchFile& file) { failed_.push_back(file.input); }

  void End() const {
    const double seconds = absl::ToDoubleSeconds(absl::Now() - start_);
    const size_t left = files_ - done_ - skipped_ - failed_.size();
    if (json_) {
      std::fputs(ToJsonLine({{"files", files_},
                             {"done", done_},
                             {"skipped", skipped_},
                             {"failed", failed_},
                             {"not_tried", left},
                             {"points", points_},
                             {"seconds", seconds}})
                     .c_str(),
                 stdout);
      return;
    }
    std::string text =
        absl::StrFormat("%s: %d done, %d skipped, %d failed", CountOf(files_, "file"), done_, skipped_, failed_.size());
    if (left > 0) absl::StrAppend(&text, ", ", left, " not tried");
    absl::StrAppendFormat(&text, "; %s in %.3f s", CountOf(points_, "point"), seconds);
    for (const std::string& input : failed_) absl::StrAppend(&text, "\n  failed: ", Visible(input));
    std::printf("%s\n", text.c_str());
  }

  bool has_failures() const { return !failed_.empty(); }

 private:
  size_t files_;
  bool json_;
  absl::Time start_;
  size_t done_ = 0;
  size_t skipped_ = 0;
  uint64_t points_ = 0;
  std::vector<std::string> failed_;
};

// The share of the bytes of the files `left` that each ends, from 0 to 1. What has no size counts for one byte.
std::vector<double> SharesOf(const std::vector<BatchFile>& files, const std::vector<size_t>& left) {
  std::vector<double> shares;
  double bytes = 0.0;
  for (const size_t i : left) {
    std::error_code unknown;
    const uintmax_t size = fs::file_size(files[i].input, unknown);
    shares.push_back(bytes += unknown ? 1.0 : 1.0 + static_cast<double>(size));
  }
  for (double& share : shares) share /= bytes;
  return shares;
}

}  // namespace

bool IsDirectory(const std::string& output) {
  std::error_code ignored;
  return output.ends_with('/') || fs::is_directory(output, ignored);
}

absl::StatusOr<std::vector<BatchFile>> PlanBatch(const std::vector<std::string>& inputs, const std::string& directory,
                                                 const std::string& format) {
  std::vector<BatchFile> files;
  std::map<std::string, std::string> input_of;
  for (const std::string& input : inputs) {
    if (input == "-") {
      return absl::InvalidArgumentError("standard input has no name for an output in a directory: name a file");
    }
    const std::string output = (fs::path(directory) / OutputName(input, format)).string();
    const auto [other, is_new] = input_of.emplace(output, input);
    if (!is_new) {
      return absl::InvalidArgumentError(
          absl::StrCat(other->second, " and ", input, " would both become ", output, ": estimate them apart"));
    }
    files.push_back({input, output});
  }
  const KeptInputs kept(inputs);
  for (const BatchFile& file : files) {
    const std::string* replaced = kept.ReplacedBy(file.output);
    if (replaced == nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("the output of ", file.input, " would replace the input ", *replaced, ": name another directory"));
  }
  return files;
}

std::string OptionsText(const CLI::App& command, const std::set<std::string>& leave_out) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || leave_out.contains(option->get_name())) continue;
    std::string values;
    for (const std::string& value : option->results()) absl::StrAppend(&values, values.empty() ? "" : ",", value);
    absl::StrAppend(&text, text.empty() ? "" : " ", option->get_name(), "=", values);
  }
  return text;
}

ExitCode RunBatch(const std::vector<BatchFile>& files, const BatchOptions& options, const std::stop_token& stop,
                  const std::function<BatchOutcome(const BatchFile& file, const BatchShare& share)>& process) {
  std::error_code error;
  fs::create_directories(options.directory, error);
  if (error) return Fail(ExitCode::kOutput, absl::StrCat("cannot make ", options.directory, ": ", error.message()));
  FinishedFiles finished(options.directory, options.options);
  BatchReport report(files.size(), options.json);
  std::vector<size_t> left;
  for (size_t i = 0; i < files.size(); ++i) {
    if (options.force || !finished.Has(files[i].input, files[i].output)) {
      left.push_back(i);
    } else {
      report.Skipped(files[i]);
    }
  }
  const std::vector<double> shares = SharesOf(files, left);
  ExitCode early = ExitCode::kOk;
  for (size_t l = 0; l < left.size() && early == ExitCode::kOk; ++l) {
    const BatchFile& file = files[left[l]];
    const BatchShare share{.title = absl::StrCat(left[l] + 1, " of ", files.size(), ", ", file.input, ": "),
                           .begin = l == 0 ? 0.0 : shares[l - 1],
                           .end = shares[l]};
    const BatchOutcome outcome = stop.stop_requested()
                                     ? BatchOutcome{.code = Fail(ExitCode::kInterrupted, "interrupted")}
                                     : process(file, share);
    if (outcome.code == ExitCode::kOk) {
      if (absl::Status status = finished.Add(file.output); !status.ok()) PrintWarning(std::string(status.message()));
      report.Done(file, outcome);
    } else if (outcome.code == ExitCode::kInterrupted || outcome.code == ExitCode::kUnavailable) {
      early = outcome.code;
    } else {
      report.Failed(file);
    }
  }
  report.End();
  if (early != ExitCode::kOk) return early;
  return report.has_failures() ? ExitCode::kFailed : ExitCode::kOk;
}

}  // namespace curv
