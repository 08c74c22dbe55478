#include "bench/server_process.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <vector>

#include "absl/strings/str_cat.h"
#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

// The address in the server's first log line, or "" if there is none.
std::string ReadAddress(FILE* log) {
  char* line = nullptr;
  size_t capacity = 0;
  std::string address;
  const std::regex pattern("\"event\":\"serving\".*\"listen\":\"([^\"]*)\"");
  while (address.empty() && getline(&line, &capacity, log) > 0) {
    std::cmatch match;
    if (std::regex_search(line, match, pattern)) address = match[1].str();
  }
  free(line);
  return address;
}

}  // namespace

ServerProcess ServerProcess::Curvd(int threads) {
  // --log=false would also silence the line that tells the port; the calls' lines are few.
  return ServerProcess(
      {CURVD_BINARY, "--listen=127.0.0.1:0", "--metrics-listen=none", absl::StrCat("--threads=", threads)});
}

ServerProcess ServerProcess::Bare(int threads) { return ServerProcess({BARE_SERVER_BINARY, absl::StrCat(threads)}); }

ServerProcess::ServerProcess(std::vector<std::string> command) {
  int ends[2];
  if (pipe(ends) != 0) std::exit(1);
  std::vector<char*> argv;
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // no server outlives a benchmark that was interrupted
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  log_ = fdopen(ends[0], "r");
  address_ = ReadAddress(log_);
  if (address_.empty() || clock_getcpuclockid(pid_, &clock_) != 0) {
    std::fprintf(stderr, "%s does not start\n", argv[0]);
    std::exit(1);
  }
}

ServerProcess::~ServerProcess() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  fclose(log_);
}

double ServerProcess::CpuSeconds() const { return SecondsOf(clock_); }

double ServerProcess::PeakBytes() const {
  std::ifstream status(absl::StrCat("/proc/", pid_, "/status"));
  std::string word;
  double kilobytes = 0.0;
  while (status >> word) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  return 1024.0 * kilobytes;
}

}  // namespace curvd::bench
