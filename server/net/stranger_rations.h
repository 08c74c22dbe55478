// Divides among strangers the bytes that they may send together.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

namespace curvd {

// What gRPC makes of a stranger's bytes is only seen when it has the memory, and then it may be too late: a call in 15
// bytes takes 13 KiB. So the system holds each stranger to a ration (receive_valve.h), and all rations together are
// bounded. Who has used his up waits for more. Where none is left, rations that are not used are taken back, and then
// those have to go who have held much for long, if they hold a good part of all: an honest caller is let in soon, and
// leaves his ration to others. A part is kept for newcomers, so that they need not wait for those. Not thread-safe.
class StrangerRations {
 public:
  using Clock = std::chrono::steady_clock;

  // What each connection may send beside: the first bytes of HTTP/2 or TLS, of which nobody can make a call.
  static constexpr uint64_t kGreetingBytes = 32;
  // What is left to who is silent, at least: it shows that he wants more. Where this part of all bytes, shared by all
  // connections, is more, it is left, up to half a newcomer's bytes: most calls need no more.
  static constexpr uint64_t kLeastKnockBytes = 32;
  static constexpr uint64_t kSilentShare = 4;
  // Who has no more than that is a newcomer: it does for a TLS handshake without a client's certificate, and a call.
  static constexpr uint64_t kNewcomerBytes = 2 << 10;
  // A quarter of all bytes is only for newcomers, until they have half. They get no more than that unless as much is
  // left as a whole call takes: somebody can always go on.
  static constexpr uint64_t kNewcomersShare = 4;
  static constexpr uint64_t kNewcomersMost = 2;
  // By how much a bound moves at once as bytes get accounted for, or by a quarter of a ration if that is less.
  static constexpr uint64_t kStepBytes = 8 << 10;
  // For how long who is silent keeps more than KnockBytes() of what he does not use, where little is left; who came
  // kStay ago keeps no more even if bytes come.
  static constexpr std::chrono::milliseconds kSilence{50};
  // But who gets more after he waited, the first times, keeps as much as a call takes of it. His peer's system sends
  // again what was cut off after a pause, which is about as long as it has been at that: so long, up to kLongestPause,
  // and for kShortestPause more, it is kept; when bytes have come, for kShortestPause at most.
  static constexpr std::chrono::milliseconds kShortestPause{500};
  static constexpr std::chrono::milliseconds kLongestPause{10'000};
  static constexpr int kPromises = 4;
  // How often unused bytes are taken back.
  static constexpr std::chrono::milliseconds kTakeBackInterval{20};
  // How long there are always some who wait until somebody has to go, whose bytes gRPC has held for kStay on average: a
  // busy server takes some time to let in who sent them. Nobody has to go unless those who have stayed so long hold
  // this part of all bytes: where they hold less, what is scarce is what a busy server has not read yet.
  static constexpr std::chrono::milliseconds kScarcity{500};
  static constexpr std::chrono::milliseconds kStay{1'000};
  static constexpr uint64_t kHoldersShare = 8;
  // For how long bytes of a connection count that has ended: gRPC frees what it held some time later. Those that wait
  // for it to pass are at most half of all, so that others can stay meanwhile.
  static constexpr std::chrono::milliseconds kAftermath{300};
  // How long a connection waits to come in.
  static constexpr std::chrono::seconds kDoorPatience{10};

  // How much of its ration a connection has used.
  enum class Use {
    kPart,
    kAll,
    // All that one may have, again and again: only who sends calls as fast as he can comes there; or as much before it
    // came in, so that it never could.
    kTooMuch,
  };
  struct Division {
    std::vector<int> enter;  // sockets of connections that may come in now
    std::optional<int> end;  // the socket of a connection that should be ended for the sake of others
  };

  // No connection gets more than `most` bytes beyond those that are accounted for. `call` is what a call takes that has
  // all metadata that it may have. REQUIRES: call <= most.
  StrangerRations(uint64_t most, uint64_t call) : most_(most), call_bytes_(call) {}

  // All rations together are at most `bytes` from now on; those that were given stay. DEFAULT: without bound.
  void Share(uint64_t bytes) { total_ = bytes; }
  // The connection of the socket `fd` gets its first ration. Returns whether it may come in: there is enough for a
  // newcomer, and for all bytes that came before, since what the system has received can only be kept from those who
  // read it. Else it waits until Divide names it. True where the system cannot hold it to a ration.
  bool Add(int fd, Clock::time_point now);
  // The connection is no stranger's any more: it gets what it likes. No effect if it has no ration.
  void Lift(int fd);
  // The connection is to end: the same, and what it has used counts for kAftermath. No effect if it has no ration.
  void End(int fd, Clock::time_point now);
  // The connection has received so many bytes; gRPC has read so many of them, and so many are accounted for. REQUIRES:
  // none of them goes back, nor does `now`, here and below.
  Use Note(int fd, uint64_t received, uint64_t read, uint64_t accounted, Clock::time_point now);
  // Gives more to those who wait: newcomers first, of them the latest, and then others, those inside before those at
  // the door, in the order in which they came, but for those who need more than there is.
  Division Divide(Clock::time_point now);

  // What is left to who is silent.
  uint64_t KnockBytes() const;
  // Bytes of all rations together, used or not, and of those that have ended.
  uint64_t held() const { return held_; }

 private:
  struct Ration {
    uint32_t beginning;              // where its bytes begin
    Clock::time_point since;         // when it came
    Clock::time_point changed;       // when bytes came
    Clock::time_point holds_since;   // since when gRPC holds bytes, on average
    uint64_t most_held = 0;          // since it last held none
    Clock::time_point cut_since{};   // since when its peer's system sends again what was cut off
    Clock::time_point kept_until{};  // until when `promised` is not taken back
    uint64_t promised = 0;
    int promises = 0;    // how often that was set
    uint64_t grant = 0;  // bytes beyond `base`
    uint64_t received = 0;
    uint64_t read = 0;               // by gRPC
    uint64_t base = kGreetingBytes;  // bytes that count for nothing
    bool inside = false;             // gRPC has the connection
    bool waits = false;              // it is in one of the queues
    bool is_cut = false;             // it was full when bytes last came

    // The byte from which on none is received.
    uint64_t bound() const { return base + (inside ? grant : kNewcomerBytes); }
    uint64_t used() const { return received - (received < base ? received : base); }
    uint64_t held_by_grpc() const { return read - (read < base ? read : base); }
  };
  struct Ended {
    Clock::time_point at;
    uint64_t bytes;
  };

  uint64_t left() const;
  // How much more the connection gets now; 0 if it has to wait.
  uint64_t More(const Ration& ration) const;
  // Has the system hold it to its bound; lifts the ration if the system cannot.
  void Bound(int fd, const Ration& ration);
  // The only writer of grants: keeps the sums of them.
  void SetGrant(Ration& ration, uint64_t grant);
  // Puts it where it waits, unless it does.
  void Queue(int fd, Ration& ration);
  // Whether the connection of `fd`, which waits, has what it needs now; its caller takes it out of its queue.
  bool Serve(int fd, Clock::time_point now, Division& division);
  // So many bytes have been received, or read by gRPC, in all.
  static void NoteReceived(Ration& ration, uint64_t received, Clock::time_point now);
  static void NoteRead(Ration& ration, uint64_t read, Clock::time_point now);
  void ForgetEnded(Clock::time_point now);
  void TakeBackUnused(Clock::time_point now);
  std::optional<int> WhoHasToGo(Clock::time_point now);

  const uint64_t most_, call_bytes_;
  uint64_t total_ = UINT64_MAX;
  uint64_t held_ = 0;
  uint64_t held_by_newcomers_ = 0;           // grants that are no larger than a newcomer gets
  std::unordered_map<int, Ration> rations_;  // by socket
  std::deque<int> newcomers_, others_;       // those that wait, in the order in which they came
  std::deque<Ended> ended_;
  uint64_t ended_bytes_ = 0;
  std::optional<Clock::time_point> scarce_since_;  // since when nothing was left for one who waits
  Clock::time_point taken_back_{};
};

}  // namespace curvd
