#include "tests/client/cli/run_curv.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks(1);

bool HasSignal(const std::string& hexadecimal_mask, int signal) {
  return (std::stoull(hexadecimal_mask, nullptr, 16) >> (signal - 1)) % 2 == 1;
}

// Whether the first thread of a process blocks SIGTERM, which it leaves to the thread that watches, or has ended. While
// it starts a thread it blocks all signals, SIGHUP as well.
bool WatchesOrHasEnded(pid_t process) {
  std::ifstream status(absl::StrCat("/proc/", process, "/status"));
  for (std::string word; status >> word;) {
    if (word == "State:" && status >> word && word == "Z") return true;
    if (word == "SigBlk:" && status >> word) return HasSignal(word, SIGTERM) && !HasSignal(word, SIGHUP);
  }
  return false;
}

}  // namespace

RunningCurv::RunningCurv(const std::vector<std::string>& arguments, const std::string& input, const std::string& output)
    : has_out_(output.empty()) {
  std::vector<std::string> words = {CURV_BINARY};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const std::string out = has_out_ ? dir_.File("out") : output;
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, dir_.File("err").c_str(), O_WRONLY | O_CREAT, 0600);
  if (!input.empty()) posix_spawn_file_actions_addopen(&actions, 0, input.c_str(), O_RDONLY, 0);
  if (posix_spawn(&child_, CURV_BINARY, &actions, nullptr, argv.data(), environ) != 0) child_ = -1;
  posix_spawn_file_actions_destroy(&actions);
}

void RunningCurv::AwaitInterruptWatch() const {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!WatchesOrHasEnded(child_) && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kBetweenLooks);
  }
}

void RunningCurv::Signal(int signal) const {
  if (child_ > 0) kill(child_, signal);
}

CurvRun RunningCurv::Wait(int most_seconds) {
  if (child_ < 0) return {-1, "", "cannot start " CURV_BINARY};
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(most_seconds);
  int status = 0;
  while (waitpid(child_, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) kill(child_, SIGKILL);
    std::this_thread::sleep_for(kBetweenLooks);
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return {code, has_out_ ? dir_.Read("out") : "", dir_.Read("err")};
}

CurvRun RunCurv(const std::vector<std::string>& arguments, const std::string& input, const std::string& output) {
  return RunningCurv(arguments, input, output).Wait();
}

}  // namespace curv
