#include "tests/fault/curvd_child.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

// The text behind "KEY":" in a line of JSON.
std::string TextIn(const std::string& line, const std::string& key) {
  const std::string before = "\"" + key + "\":\"";
  const size_t found = line.find(before);
  if (found == std::string::npos) return "";
  const size_t first = found + before.size();
  return line.substr(first, line.find('"', first) - first);
}

std::string HttpGet(const std::string& address, const std::string& path) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
  if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0 &&
      write(fd, request.data(), request.size()) == static_cast<ssize_t>(request.size())) {
    char buffer[65'536];
    for (ssize_t count = 0; (count = read(fd, buffer, sizeof(buffer))) > 0;) answer.append(buffer, count);
  }
  close(fd);
  return answer;
}

// The number behind "NAME:" in /proc/PID/status.
uint64_t StatusNumber(const std::string& status, const std::string& name) {
  const size_t found = status.find("\n" + name + ":");
  return found == std::string::npos ? 0 : std::strtoull(status.c_str() + found + name.size() + 2, nullptr, 10);
}

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

void Fail(const std::string& message) {
  std::fflush(stdout);
  std::fprintf(stderr, "finding: %s\n", message.c_str());
  // Threads may still be at work: no destructors.
  std::_Exit(1);
}

CurvdChild::CurvdChild(const std::string& binary, std::vector<std::string> flags) {
  flags.insert(flags.begin(), {binary, "--listen=127.0.0.1:0", "--metrics-listen=127.0.0.1:0"});
  std::vector<char*> argv;
  argv.reserve(flags.size() + 1);
  for (std::string& flag : flags) argv.push_back(flag.data());
  argv.push_back(nullptr);
  int ends[2];
  if (pipe(ends) != 0) Fail("no pipe");
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // no server outlives a program that was killed
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  FILE* log = fdopen(ends[0], "r");
  char* line = nullptr;
  size_t capacity = 0;
  while (address_.empty() && getline(&line, &capacity, log) > 0) {
    address_ = TextIn(line, "listen");
    metrics_address_ = TextIn(line, "metrics_listen");
  }
  std::free(line);
  if (address_.empty()) Fail(absl::StrCat(binary, " does not serve"));
  // Somebody has to read on, or curvd would drop its log; a program like this one is not interested in it.
  std::thread([log] {
    while (std::fgetc(log) != EOF) {
    }
    std::fclose(log);
  }).detach();
}

CurvdChild::~CurvdChild() {
  kill(pid_, SIGTERM);
  int status = 0;
  waitpid(pid_, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) Fail(absl::StrCat("curvd ended with wait status ", status));
}

double CurvdChild::Metric(const std::string& series) const {
  const std::string text = HttpGet(metrics_address_, "/metrics");
  const size_t found = text.find("\n" + series + " ");
  return found == std::string::npos ? 0.0 : std::atof(text.c_str() + found + series.size() + 2);
}

bool CurvdChild::IsIdle() const {
  for (const char* series : {"curvd_streams_open", "curvd_memory_reserved_bytes", "curvd_queue_jobs{queue=\"memory\"}",
                             "curvd_workers_busy"}) {
    if (Metric(series) != 0.0) return false;
  }
  return true;
}

void CurvdChild::WaitUntilIdle() const {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!IsIdle()) {
    if (std::chrono::steady_clock::now() > deadline) Fail("curvd is not idle a minute after the last call");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

ProcessUsage CurvdChild::Usage() const {
  const std::string directory = absl::StrCat("/proc/", pid_);
  const std::string status = ReadFile(directory + "/status");
  ProcessUsage usage;
  usage.resident_bytes = StatusNumber(status, "VmRSS") << 10;
  usage.peak_bytes = StatusNumber(status, "VmHWM") << 10;
  usage.threads = static_cast<int>(StatusNumber(status, "Threads"));
  std::error_code error;
  for (std::filesystem::directory_iterator it(directory + "/fd", error), end; !error && it != end;
       it.increment(error)) {
    ++usage.descriptors;
  }
  return usage;
}

uint64_t CurvdChild::CpuNanoseconds() const {
  uint64_t sum = 0;
  std::error_code error;
  const std::string tasks = absl::StrCat("/proc/", pid_, "/task");
  for (std::filesystem::directory_iterator it(tasks, error), end; !error && it != end; it.increment(error)) {
    sum += std::strtoull(ReadFile(it->path().string() + "/schedstat").c_str(), nullptr, 10);
  }
  return sum;
}

bool CurvdChild::IsAlive() const { return kill(pid_, 0) == 0; }

}  // namespace curvd
