#include "tests/integration/process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <regex>

namespace curvd {

Process::Process(std::vector<std::string> arguments,
                 const std::vector<std::pair<std::string, std::string>>& environment) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  arguments.insert(arguments.begin(), CURVD_BINARY);
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  output_ = fdopen(ends[0], "r");
}

Process::~Process() {
  if (!waited_) {
    Signal(SIGKILL);
    WaitForExit();
  }
  fclose(output_);
}

void Process::Signal(int number) const { kill(pid_, number); }

std::string Process::WaitForLine(const std::string& text) {
  char* line = nullptr;
  size_t capacity = 0;
  std::string found;
  while (found.empty() && getline(&line, &capacity, output_) > 0) {
    if (std::string(line).find(text) != std::string::npos) found = line;
  }
  free(line);
  EXPECT_FALSE(found.empty()) << "no line with " << text;
  return found;
}

std::string Process::ReadAll() {
  std::string text;
  for (int c = fgetc(output_); c != EOF; c = fgetc(output_)) text += static_cast<char>(c);
  return text;
}

int Process::WaitForExit() {
  int status = 0;
  waitpid(pid_, &status, 0);
  waited_ = true;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string ValueIn(const std::string& line, const std::string& key) {
  std::smatch match;
  const std::regex pattern("\"" + key + "\":\"([^\"]*)\"");
  return std::regex_search(line, match, pattern) ? match[1].str() : "";
}

}  // namespace curvd
