#include "tests/fault/soak_strangers.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <iterator>
#include <utility>

#include "tests/fault/curvd_child.h"

namespace curvd {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kAttacks[] = {"references",   "long_string", "rapid_reset", "half_messages",
                                    "many_streams", "small_calls", "drip"};
constexpr auto kLongest = std::chrono::minutes(1);
constexpr auto kPoll = std::chrono::milliseconds(20);

pid_t StartAttack(const std::string& attacks, const char* name, const std::string& address) {
  const char* const argv[] = {"python3",      attacks.c_str(),   name,   address.c_str(),
                              "--linger=0.5", "--connections=2", nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, argv[0], &actions, nullptr, const_cast<char* const*>(argv), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) Fail("python3 cannot be started");
  return pid;
}

}  // namespace

SoakStrangers::SoakStrangers(std::string attacks, std::string address)
    : attacks_(std::move(attacks)), address_(std::move(address)) {
  if (!attacks_.empty()) thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void SoakStrangers::Run(const std::stop_token& stop) const {
  for (size_t i = 0; !stop.stop_requested(); ++i) {
    const pid_t pid = StartAttack(attacks_, kAttacks[i % std::size(kAttacks)], address_);
    const Clock::time_point started = Clock::now();
    int status = 0;
    pid_t ended = 0;
    while ((ended = waitpid(pid, &status, WNOHANG)) == 0) {
      if (stop.stop_requested()) kill(pid, SIGKILL);
      if (Clock::now() > started + kLongest) Fail("a stranger's attack was not over after a minute");
      std::this_thread::sleep_for(kPoll);
    }
    const bool was_killed = WIFSIGNALED(status) && stop.stop_requested();
    if (ended != pid || (status != 0 && !was_killed)) Fail("a stranger's attack failed");
  }
}

}  // namespace curvd
