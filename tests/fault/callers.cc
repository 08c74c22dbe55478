// What one caller has to suffer from others: from clouds that are made to cost much, from a flood of calls, and from
// memory that is held for nothing. Prints a row for each trial.
//
//   fault_callers --curvd=PATH [--times=20] [--flood=60] [--only=TRIAL]
// Ends with status 1 if a caller has to wait longer than is promised.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/raw_call.h"
#include "tests/fault/token_file.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using Clock = std::chrono::steady_clock;

constexpr double kAllowedRatio = 5.0;
// A call that has to wait until memory is given back: by a call that ends, and by one that lends it after two seconds.
constexpr double kAllowedMemoryRatio = 10.0;
constexpr double kAllowedLendingRatio = 50.0;
constexpr int kCallsATime = 25;
constexpr auto kEnough = std::chrono::seconds(20);  // for the calls of a trial
constexpr auto kLongestTrial = std::chrono::minutes(2);
constexpr auto kPoll = std::chrono::milliseconds(10);
// What --memory-limit=256MiB leaves to one call.
constexpr uint64_t kPointsOfAllMemory = 2'290'000;
constexpr char kWaitForMemory[] = "curvd_queue_jobs{queue=\"memory\"}";

struct Flags {
  std::string curvd;
  int times = 20;
  int flood = 60;
  std::string only;
};

// Connections of one caller.
struct Caller {
  std::string token;
  std::shared_ptr<grpc::Channel> channel;

  std::unique_ptr<RawCall> Call() const {
    auto call = std::make_unique<RawCall>(channel);
    call->context().AddMetadata("authorization", BearerOf(token));
    call->context().set_deadline(std::chrono::system_clock::now() + kLongestTrial);
    return call;
  }
};

v1::CloudHeader HeaderFor(uint64_t points) {
  v1::CloudHeader header;
  header.set_point_count(points);
  return header;
}

double SecondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Seconds that a call takes; the status of one that fails is a finding.
double TimeCall(const Caller& caller, const FaultCloud& cloud) {
  const Clock::time_point start = Clock::now();
  const auto call = caller.Call();
  if (call->SendHeader(HeaderFor(cloud.size()))) call->SendCloud(cloud);
  call->HalfClose();
  const grpc::Status status = call->Finish();
  if (!status.ok()) Fail(absl::StrCat(caller.token, " after ", SecondsSince(start), " s: ", status.error_message()));
  return SecondsSince(start);
}

double Median(std::vector<double> numbers) {
  std::nth_element(numbers.begin(), numbers.begin() + numbers.size() / 2, numbers.end());
  return numbers[numbers.size() / 2];
}

// Seconds of up to `count` calls, one after the other; of fewer if they take too long.
std::vector<double> TimeCalls(const Caller& caller, const FaultCloud& cloud, int count) {
  std::vector<double> seconds;
  const Clock::time_point start = Clock::now();
  while (static_cast<int>(seconds.size()) < count && (seconds.empty() || Clock::now() < start + kEnough)) {
    seconds.push_back(TimeCall(caller, cloud));
  }
  return seconds;
}

void WaitUntil(const std::function<bool()>& condition) {
  const Clock::time_point start = Clock::now();
  while (!condition()) {
    if (Clock::now() > start + kLongestTrial) Fail("the other callers do not get so far");
    std::this_thread::sleep_for(kPoll);
  }
}

// Calls of one caller, all open at once and made again when they end, until destroyed.
class Flood {
 public:
  Flood(const Caller& caller, int calls, const v1::CloudHeader& header, const FaultCloud& cloud) {
    for (int i = 0; i < calls; ++i) {
      threads_.emplace_back([this, caller, header, &cloud] {
        while (!stops_) {
          const auto call = caller.Call();
          if (call->SendHeader(header)) call->SendCloud(cloud);
          call->HalfClose();
          Watch(*call);
        }
      });
    }
  }
  ~Flood() {
    stops_ = true;
    for (std::jthread& thread : threads_) thread.join();
  }

 private:
  // Reads to the end, or cancels.
  void Watch(RawCall& call) {
    v1::EstimateCurvatureResponse message;
    while (!stops_ && call.Read(message)) {
    }
  }

  std::atomic<bool> stops_ = false;
  std::vector<std::jthread> threads_;
};

std::vector<std::string> ServerFlags(const TokenFile& tokens, const char* memory) {
  return {"--log=false", "--threads=2", absl::StrCat("--memory-limit=", memory),
          absl::StrCat("--token-file=", tokens.path())};
}

// Medians of each trial, in seconds.
struct Row {
  std::vector<double> idle, beside;
  double longest = 0.0;
};

// Prints the row. Returns whether the median is at most `allowed` times as long as on the idle server.
bool Print(const char* name, const Row& row, double allowed) {
  std::vector<double> ratios;
  for (size_t i = 0; i < row.beside.size(); ++i) ratios.push_back(row.beside[i] / row.idle[i]);
  const double ratio = Median(ratios);
  std::printf("| %s | %zu | %.1f | %.1f | %.1f | %.1f | %.0f |\n", name, row.beside.size(), 1e3 * Median(row.idle),
              1e3 * Median(row.beside), 1e3 * row.longest, ratio, allowed);
  std::fflush(stdout);
  return ratio <= allowed;
}

// Bob's calls on an idle server, and beside what `disturb` makes of the others until what it returns is destroyed.
template <typename Disturb>
Row TryBeside(const CurvdChild& curvd, const Caller& bob, const FaultCloud& cloud, int times, int calls,
              const Disturb& disturb) {
  Row row;
  for (int i = 0; i < times; ++i) {
    row.idle.push_back(Median(TimeCalls(bob, cloud, calls)));
    {
      const auto disturbance = disturb();
      const std::vector<double> seconds = TimeCalls(bob, cloud, calls);
      row.beside.push_back(Median(seconds));
      row.longest = std::max(row.longest, *std::max_element(seconds.begin(), seconds.end()));
    }
    curvd.WaitUntilIdle();
  }
  return row;
}

// The workers: many expensive calls of one caller beside small ones of another.
bool FloodOfWork(const Flags& flags) {
  const TokenFile tokens;
  const CurvdChild curvd(flags.curvd, ServerFlags(tokens, "1GiB"));
  const Caller alice{"alice", OwnChannel(curvd.address())}, bob{"bob", OwnChannel(curvd.address())};
  const FaultCloud small(1'000, 1), large(100'000, 2);
  v1::CloudHeader expensive = HeaderFor(large.size());
  expensive.mutable_options()->set_neighbor_count(1'000);
  expensive.set_priority(v1::PRIORITY_INTERACTIVE);
  const Row row = TryBeside(curvd, bob, small, flags.times, kCallsATime, [&] {
    auto flood = std::make_unique<Flood>(alice, flags.flood, expensive, large);
    WaitUntil([&] {
      return curvd.Metric("curvd_streams_open") >= flags.flood &&
             curvd.Metric("curvd_queue_jobs{queue=\"workers\"}") >= flags.flood / 2;
    });
    return flood;
  });
  return Print("1,000 points beside 60 calls of 100,000 points at K = 1,000", row, kAllowedRatio);
}

// Memory: five times as many calls of one caller as fit, beside a call of another.
bool FloodOfMemory(const Flags& flags) {
  const TokenFile tokens;
  const CurvdChild curvd(flags.curvd, ServerFlags(tokens, "256MiB"));
  const Caller alice{"alice", OwnChannel(curvd.address())}, bob{"bob", OwnChannel(curvd.address())};
  const FaultCloud medium(200'000, 1), large(500'000, 2);
  const Row row = TryBeside(curvd, bob, medium, flags.times, 1, [&] {
    auto flood = std::make_unique<Flood>(alice, flags.flood, HeaderFor(large.size()), large);
    WaitUntil([&] { return curvd.Metric(kWaitForMemory) >= flags.flood / 2; });
    return flood;
  });
  return Print("200,000 points beside 60 calls of 500,000 points in 256 MiB", row, kAllowedMemoryRatio);
}

// Opens a call for `points` points and sends `sent` points every half a second, until destroyed.
class SlowCall {
 public:
  SlowCall(const Caller& caller, uint64_t points, size_t sent) : call_(caller.Call()), cloud_(1'000, 3) {
    call_->SendHeader(HeaderFor(points));
    sender_ = std::jthread([this, sent](const std::stop_token& stop) {
      for (size_t first = 0; !stop.stop_requested() && call_->SendPoints(cloud_, first, sent); first += sent) {
        for (int i = 0; i < 50 && !stop.stop_requested(); ++i) std::this_thread::sleep_for(kPoll);
      }
    });
  }
  ~SlowCall() {
    sender_.request_stop();
    call_->Cancel();
  }

 private:
  std::unique_ptr<RawCall> call_;
  const FaultCloud cloud_;
  std::jthread sender_;
};

// Memory that is held for nothing: a header for all of it, and chunks without points.
bool HeldForNothing(const Flags& flags) {
  const TokenFile tokens;
  const CurvdChild curvd(flags.curvd, ServerFlags(tokens, "256MiB"));
  const Caller alice{"alice", OwnChannel(curvd.address())}, bob{"bob", OwnChannel(curvd.address())};
  const FaultCloud medium(500'000, 1);
  const Row row = TryBeside(curvd, bob, medium, flags.times, 1, [&] {
    auto holder = std::make_unique<SlowCall>(alice, kPointsOfAllMemory, 0);
    WaitUntil([&] { return curvd.Metric("curvd_memory_reserved_bytes") > 200e6; });
    return holder;
  });
  return Print("500,000 points beside a header for all memory and empty chunks", row, kAllowedLendingRatio);
}

// A call that wants all memory waits behind a slow one that holds little of it.
bool WaitingForAll(const Flags& flags) {
  const TokenFile tokens;
  const CurvdChild curvd(flags.curvd, ServerFlags(tokens, "256MiB"));
  const Caller alice{"alice", OwnChannel(curvd.address())}, bob{"bob", OwnChannel(curvd.address())},
      carol{"carol", OwnChannel(curvd.address())};
  const FaultCloud medium(500'000, 1);
  using Calls = std::pair<std::unique_ptr<SlowCall>, std::unique_ptr<SlowCall>>;
  const Row row = TryBeside(curvd, bob, medium, flags.times, kCallsATime, [&] {
    Calls calls;
    calls.first = std::make_unique<SlowCall>(alice, 300'000, 1);
    WaitUntil([&] { return curvd.Metric("curvd_memory_reserved_bytes") > 20e6; });
    calls.second = std::make_unique<SlowCall>(carol, kPointsOfAllMemory, 0);
    WaitUntil([&] { return curvd.Metric(kWaitForMemory) > 0; });
    return calls;
  });
  return Print("500,000 points beside a waiting call for all memory", row, kAllowedRatio);
}

// A cloud of `count` points that are all equal.
FaultCloud EqualPoints(size_t count) {
  FaultCloud cloud(count, 4);
  std::fill(cloud.positions.begin(), cloud.positions.end(), 1.0f);
  return cloud;
}

// A cloud with one point that is as far away as a broken scanner may put it.
FaultCloud WithOutlier(size_t count) {
  FaultCloud cloud(count, 5);
  cloud.positions[0] = 1e30f;
  return cloud;
}

// One call after another of one caller with a cloud that is made to cost much, beside small ones of another.
bool BesideHostileCloud(const Flags& flags, const char* name, v1::Estimator estimator, const FaultCloud& hostile) {
  const TokenFile tokens;
  const CurvdChild curvd(flags.curvd, ServerFlags(tokens, "1GiB"));
  const Caller alice{"alice", OwnChannel(curvd.address())}, bob{"bob", OwnChannel(curvd.address())};
  const FaultCloud small(1'000, 1);
  v1::CloudHeader header = HeaderFor(hostile.size());
  header.mutable_options()->set_estimator(estimator);
  const Row row = TryBeside(curvd, bob, small, flags.times, kCallsATime, [&] {
    auto calls = std::make_unique<Flood>(alice, 1, header, hostile);
    WaitUntil([&] { return curvd.Metric("curvd_workers_busy") > 0; });
    return calls;
  });
  return Print(name, row, kAllowedRatio);
}

bool HostileClouds(const Flags& flags) {
  bool all_well = BesideHostileCloud(flags, "1,000 points beside 1,000,000 equal points", v1::ESTIMATOR_AVG_HEXAGRAM,
                                     EqualPoints(1'000'000));
  all_well &= BesideHostileCloud(flags, "1,000 points beside 3,000,000 equal points with Delaunay",
                                 v1::ESTIMATOR_DELAUNAY, EqualPoints(3'000'000));
  all_well &= BesideHostileCloud(flags, "1,000 points beside 200,000 points, one of them at 1e30",
                                 v1::ESTIMATOR_AVG_HEXAGRAM, WithOutlier(200'000));
  return all_well;
}

constexpr std::pair<const char*, bool (*)(const Flags&)> kTrials[] = {{"clouds", HostileClouds},
                                                                      {"work", FloodOfWork},
                                                                      {"memory", FloodOfMemory},
                                                                      {"held", HeldForNothing},
                                                                      {"waiting", WaitingForAll}};

int Main(int argc, char** argv) {
  Flags flags;
  CLI::App app("What one caller has to suffer from others", "fault_callers");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--times", flags.times)->capture_default_str();
  app.add_option("--flood", flags.flood, "calls that the other has open")->capture_default_str();
  app.add_option("--only", flags.only, "one trial: clouds, work, memory, held or waiting");
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "| one caller's call, beside another caller | times | idle ms | beside ms | longest ms | times as long | "
      "allowed |\n| --- | --: | --: | --: | --: | --: | --: |\n");
  bool all_well = true;
  for (const auto& [name, trial] : kTrials) {
    if (flags.only.empty() || flags.only == name) all_well &= trial(flags);
  }
  return all_well ? 0 : 1;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
