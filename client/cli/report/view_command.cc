#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/report/page_flags.h"
#include "client/report/page_server.h"
#include "client/report/report_page.h"
#include "client/report/served_report.h"

namespace curv {
namespace {

constexpr char kViewExamples[] =
    "Examples:\n"
    "  curv view result.ply --quantity=gaussian\n"
    "  curv view result.ply --watch &\n"
    "  curv estimate scan.ply -o result.ply --auto\n"
    "Open the address that it prints in a browser of this machine; nobody else can guess it. Points are drawn as they\n"
    "come. The page itself decompresses a LAZ or COPC file that this curv cannot, and shows 1,000,000 of its points "
    "unless\n"
    "--points asks for more. Ctrl-C ends it, with exit code 0. curv report writes the same page into a file.";

struct ViewFlags {
  PageFlags page{.usual_points = 10'000'000};
  uint64_t port = 0;
  bool watch = false;
};

// Serves the file of a view, and each that takes its place.
class FileFollower {
 public:
  // `has_codec`: whether the page can decompress LAZ.
  FileFollower(const ViewFlags& flags, bool has_codec, const InterruptWatch& interrupt, ReportShelf& shelf)
      : flags_(flags), has_codec_(has_codec), interrupt_(interrupt), shelf_(shelf) {}

  // Serves the file as it is now.
  absl::Status ServeNow(const std::stop_token& stop) {
    seen_ = FileStamp::Of(flags_.page.input);
    absl::StatusOr<PageContent> content = Read();
    if (!content.ok()) return content.status();
    if (content->laz.has_value()) return ServeCompressed(*std::move(content->laz), content->options);
    const absl::Status status =
        ServeReport(content->table, content->options, generation_ + 1, flags_.watch, stop, shelf_);
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(flags_.page.input, ": ", status.message()));
    }
    ++generation_;
    return absl::OkStatus();
  }

  // Has the page wait for the file, which cannot be shown for that reason.
  void WaitForFile(const absl::Status& problem) {
    if (seen_.exists) PrintNote(std::string(problem.message()));
    ServeWaiting(flags_.page.input.substr(flags_.page.input.rfind('/') + 1), shelf_);
  }

  // Serves the file again whenever it has changed, and has not between two looks, so that who writes it is done.
  void Follow(const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kBetweenLooks(200);
    std::mutex mutex;
    std::condition_variable_any wait;
    std::unique_lock lock(mutex);
    FileStamp last = seen_;
    while (!wait.wait_for(lock, stop, kBetweenLooks, [&] { return stop.stop_requested(); })) {
      const FileStamp now = FileStamp::Of(flags_.page.input);
      const bool is_steady = now == last;
      last = now;
      if (!is_steady || now == seen_ || !now.exists) continue;
      if (const absl::Status status = ServeNow(stop); !status.ok()) PrintNote(std::string(status.message()));
    }
  }

 private:
  // A pipe may never end. Where nothing was served before, nobody misses the page.
  absl::StatusOr<PageContent> Read() const {
    std::error_code unknown;
    const bool has_end = std::filesystem::is_regular_file(flags_.page.input, unknown);
    const InterruptWatch::EndsAtOnce at_once(interrupt_, generation_ == 0 && !has_end);
    return ReadContent(flags_.page);
  }

  absl::Status ServeCompressed(LazFile laz, const ReportOptions& options) {
    if (!has_codec_) {
      return absl::InvalidArgumentError(
          absl::StrCat(flags_.page.input,
                       ": the points are compressed now, and were not before: start curv view again to show them"));
    }
    ServeLaz(std::move(laz), options, ++generation_, flags_.watch, shelf_);
    return absl::OkStatus();
  }

  // What changes when a file is written or replaced.
  struct FileStamp {
    bool exists = false;
    ino_t inode = 0;
    off_t size = 0;
    int64_t seconds = 0, nanoseconds = 0;

    static FileStamp Of(const std::string& path) {
      struct stat status {};
      if (stat(path.c_str(), &status) != 0) return {};
      return {true, status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
    }
    bool operator==(const FileStamp&) const = default;
  };

  const ViewFlags& flags_;
  const bool has_codec_;
  const InterruptWatch& interrupt_;
  ReportShelf& shelf_;
  FileStamp seen_;
  uint64_t generation_ = 0;
};

ExitCode Run(const ViewFlags& flags) {
  if (flags.watch && flags.page.input == "-") {
    return Fail(ExitCode::kUsage, "--watch needs a file: standard input comes once");
  }
  // Before anything is opened, so that an interrupt at any time ends the command well.
  InterruptWatch interrupt;
  const auto shelf = std::make_shared<ReportShelf>();
  const bool needs_codec = NeedsCodec(flags.page);
  absl::StatusOr<PageServer> server =
      PageServer::Create(static_cast<uint16_t>(flags.port), MakeViewPage(needs_codec), shelf);
  if (!server.ok()) return Fail(ExitCode::kUsage, server.status());
  std::stop_source ended;
  const std::stop_callback interrupted(interrupt.token(), [&] { ended.request_stop(); });
  absl::Status problem;
  std::jthread making([&] {
    FileFollower follower(flags, needs_codec, interrupt, *shelf);
    problem = follower.ServeNow(ended.get_token());
    if (flags.watch) {
      if (!problem.ok()) follower.WaitForFile(problem);
      problem = absl::OkStatus();
      follower.Follow(ended.get_token());
    } else if (!problem.ok()) {
      ended.request_stop();
    }
  });
  if (shelf->AwaitFirst(ended.get_token())) {
    std::printf("%s\n", server->url().c_str());
    std::fflush(stdout);
    server->Serve(ended.get_token());
  }
  ended.request_stop();
  making.join();
  return problem.ok() ? ExitCode::kOk : Fail(ExitCode::kInput, problem);
}

}  // namespace

void AddView(CLI::App& app, Action& action) {
  auto flags = std::make_shared<ViewFlags>();
  CLI::App* command = app.add_subcommand("view", "Show a result in a browser of this machine, as curv report does");
  command->footer(absl::StrCat(kViewExamples, "\n", kExitCodesHelp));
  AddPageFlags(*command, flags->page);
  command->add_flag("--watch", flags->watch,
                    "show each new version of the file as soon as it is written; it need not be there yet");
  command->add_option("--port", flags->port, "port of 127.0.0.1 to listen on [a free one]")
      ->check(Whole(0, 65535))
      ->option_text("PORT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
