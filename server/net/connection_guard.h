// Ends connections that make the process hold more than they should.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <unordered_set>
#include <vector>

#include "server/host/memory_pressure.h"
#include "server/net/connection_registry.h"

namespace curvd {

// gRPC 1.51 bounds neither the metadata of a call before its peer answers SETTINGS, nor calls that are reset, nor
// messages of calls that nobody has seen yet; and a header that comes in small pieces costs the square of its length.
// So the guard looks every few milliseconds at each connection from which bytes come: what gRPC has read of them must
// be accounted for by calls (ByteAccount), and what strangers have sent must be so in time. And it looks at the memory
// of the process. Where that is too much, it gives back what was freed, and ends strangers' connections, the largest
// first; then also others that have sent much that no call accounts for. Not thread-safe.
class ConnectionGuard {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kInterval{5};
  // As long as none of them is a stranger's.
  static constexpr std::chrono::milliseconds kLongInterval{20};
  // How often connections are looked at that are quiet and owe something.
  static constexpr std::chrono::milliseconds kSlowInterval{1000};
  // How many connections are looked at in one turn: 100 microseconds' work.
  static constexpr size_t kLooksInTurn = 50;
  // How often a connection is looked at in vain until it counts as quiet.
  static constexpr int kQuietLooks = 10;
  // What gRPC makes of a byte at worst: a call in 15 bytes takes 13 KiB. Strangers together may send as much as fits
  // the memory that is left.
  static constexpr uint64_t kWorstGrowth = 1'200;
  // What strangers that are spared one by one may have sent together while memory is high, and while it is critical, if
  // giving back what was freed did not help.
  static constexpr uint64_t kStrangersTogether = 256 << 10;
  static constexpr uint64_t kSparedTogether = 32 << 10;
  // What a connection of which calls were let in may have unaccounted for while memory is critical.
  static constexpr uint64_t kSparedLetInBytes = 256 << 10;

  // Both must outlive this.
  ConnectionGuard(ConnectionRegistry& connections, MemoryPressure& memory)
      : connections_(connections), memory_(memory) {}

  // Bytes came from the connection of `watch`, which is looked at from now on, until it is quiet. REQUIRES: it is
  // quiet, as it is in the beginning.
  void Wake(int watch);
  // It is no longer in the registry.
  void Forget(int watch);
  // How long to wait for the next turn, in milliseconds; -1 if all is quiet.
  int WaitMs(Clock::time_point now) const;
  // Watches of connections.
  struct Sights {
    std::vector<int> quiet;  // that have become quiet
    std::vector<int> enter;  // that may enter now
  };
  // Does what is due at `now`, given the memory of the process, and returns what it saw.
  Sights Turn(Clock::time_point now, uint64_t resident_bytes);
  // What strangers may send together, given the memory of the process. Each turn says so, too.
  void ShareAmongStrangers(uint64_t resident_bytes);
  // Whether one more connection may be taken: not while memory is critical and strangers were found to hold some of it.
  bool MayTake() const { return !refuses_; }

 private:
  struct Awake {
    int watch;
    int looks_in_vain;
  };

  // Looks at those that are awake, up to kLooksInTurn. Returns those that have become quiet.
  std::vector<int> LookAtAwake(Clock::time_point now);
  // Looks at those that are quiet and owe something.
  void LookAtDebtors(Clock::time_point now);
  // Ends connections until memory will do.
  void Shed(Clock::time_point now);

  ConnectionRegistry& connections_;
  MemoryPressure& memory_;
  MemoryPressure::Level level_ = MemoryPressure::Level::kFine;
  std::deque<Awake> awake_;          // in the order of their turns
  std::unordered_set<int> debtors_;  // watches of those that are, or were lately, quiet and owed something
  Clock::time_point debtors_due_{};
  bool saw_strangers_ = false;  // in the last turn
  bool refuses_ = false;
  Clock::time_point last_turn_{};
  Clock::time_point next_turn_{};  // at once in the beginning
};

}  // namespace curvd
