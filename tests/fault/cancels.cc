// Cancels many calls at random moments of every phase, and looks for what they leave behind; then measures how long
// after a cancel the server still spends CPU on the call.
//
//   fault_cancels --curvd=PATH [--cancels=100000] [--points=1000000] [--limit-ms=100]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <random>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/raw_call.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr v1::Estimator kEstimators[] = {v1::ESTIMATOR_AVG_HEXAGRAM,
                                         v1::ESTIMATOR_HEXAGRAM,
                                         v1::ESTIMATOR_UNIFORM,
                                         v1::ESTIMATOR_INDEPENDENT,
                                         v1::ESTIMATOR_DELAUNAY,
                                         v1::ESTIMATOR_JET_FITTING,
                                         v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR,
                                         v1::ESTIMATOR_NORMAL_REGRESSION};
constexpr int kClients = 8;

struct Flags {
  std::string curvd;
  int cancels = 100'000;
  size_t points = 1'000'000;
  int limit_ms = 100;
};

// How far a call gets before it is cancelled.
enum class Moment { kStart, kHeader, kReceiving, kWorking, kSending, kEnd };

void CancelOne(const std::shared_ptr<grpc::Channel>& channel, const FaultCloud& cloud, std::mt19937_64& random) {
  const auto moment = static_cast<Moment>(random() % static_cast<int>(Moment::kEnd));
  v1::CloudHeader header;
  if (random() % 2 == 0) header.set_point_count(cloud.size());
  header.mutable_options()->set_estimator(kEstimators[random() % std::size(kEstimators)]);
  RawCall call(channel);
  if (random() % 8 == 0) {
    // A deadline is a cancel by the server's own clock.
    call.context().set_deadline(std::chrono::system_clock::now() + microseconds(random() % 20'000));
  }
  call.Start();
  if (moment >= Moment::kHeader) call.SendHeader(header);
  if (moment == Moment::kReceiving) call.SendPoints(cloud, 0, random() % cloud.size());
  if (moment >= Moment::kWorking) {
    call.SendCloud(cloud);
    call.HalfClose();
  }
  if (moment == Moment::kSending) call.ReadFirstResult();
  // Up to the time that the work on a cloud takes.
  std::this_thread::sleep_for(microseconds(random() % (moment == Moment::kWorking ? 10'000 : 300)));
  call.Cancel();
  call.Finish();
}

// Makes `count` cancels from several clients, each of which changes its connection now and then.
void CancelMany(const CurvdChild& curvd, int count, uint64_t seed) {
  const std::vector<FaultCloud> clouds = {FaultCloud(300, 1), FaultCloud(3'000, 2), FaultCloud(20'000, 3)};
  std::atomic<int> left = count;
  std::vector<std::thread> clients;
  clients.reserve(kClients);
  for (int client = 0; client < kClients; ++client) {
    clients.emplace_back([&, client] {
      std::mt19937_64 random(seed + client);
      std::shared_ptr<grpc::Channel> channel;
      for (int i = 0; left.fetch_sub(1) > 0; ++i) {
        if (i % 100 == 0) channel = OwnChannel(curvd.address());
        CancelOne(channel, clouds[random() % clouds.size()], random);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  curvd.WaitUntilIdle();
}

void Print(const char* when, const ProcessUsage& usage) {
  std::printf("| %s | %.1f | %d | %d |\n", when, static_cast<double>(usage.resident_bytes) / (1 << 20), usage.threads,
              usage.descriptors);
  std::fflush(stdout);
}

void LookForLeftovers(const CurvdChild& curvd, int cancels) {
  // The first calls fill caches of the allocator and gRPC's pool of threads; what is looked for grows with their
  // number.
  CancelMany(curvd, std::max(cancels / 10, 100), 1);
  const ProcessUsage before = curvd.Usage();
  std::printf("| cancels | resident MiB | threads | descriptors |\n| --- | --: | --: | --: |\n");
  Print("before", before);
  constexpr int kParts = 4;
  ProcessUsage after;
  for (int part = 1; part <= kParts; ++part) {
    CancelMany(curvd, cancels / kParts, 1'000 * part);
    after = curvd.Usage();
    Print(absl::StrCat(cancels / kParts * part).c_str(), after);
  }
  if (curvd.Metric("curvd_failures_total{reason=\"INTERNAL\"}") != 0.0) Fail("a call ended with INTERNAL");
  // gRPC's pool keeps a few threads more or less; connections are closed by the time the last call is forgotten.
  constexpr int kThreadsOfThePool = 8, kClosingConnections = 2 * kClients;
  if (after.threads > before.threads + kThreadsOfThePool) Fail("threads were left behind");
  if (after.descriptors > before.descriptors + kClosingConnections) Fail("descriptors were left behind");
  constexpr uint64_t kAllocatorSlack = 16 << 20;
  if (after.resident_bytes > before.resident_bytes + before.resident_bytes / 10 + kAllocatorSlack) {
    Fail("memory was left behind");
  }
}

// Milliseconds from now until curvd has used no CPU worth mentioning for a while.
double MillisecondsUntilQuiet(const CurvdChild& curvd) {
  constexpr auto kStep = milliseconds(1);
  constexpr auto kQuiet = milliseconds(60);
  constexpr double kIdleShare = 0.2;  // of one CPU, for the ticker and for the end of the call itself
  const Clock::time_point start = Clock::now();
  Clock::time_point last_busy = start, last = start;
  uint64_t used = curvd.CpuNanoseconds();
  while (last - last_busy < kQuiet) {
    std::this_thread::sleep_for(kStep);
    const uint64_t now_used = curvd.CpuNanoseconds();
    const Clock::time_point now = Clock::now();
    const double share = static_cast<double>(now_used - used) / static_cast<double>((now - last).count());
    if (share > kIdleShare) last_busy = now;
    used = now_used;
    last = now;
  }
  return std::chrono::duration<double, std::milli>(last_busy - start).count();
}

// The cancels of one kind of call.
class CancelTimes {
 public:
  CancelTimes(const CurvdChild& curvd, const FaultCloud& cloud, const v1::CloudHeader& header)
      : curvd_(curvd), cloud_(cloud), header_(header) {}

  // Runs the call to its end, to know when its phases are.
  v1::PhaseSeconds Undisturbed() {
    RawCall call(OwnChannel(curvd_.address()));
    call.SendHeader(header_);
    call.SendCloud(cloud_);
    call.HalfClose();
    const grpc::Status status = call.Finish();
    if (!status.ok() || !call.summary()) Fail(absl::StrCat("an undisturbed call fails: ", status.error_message()));
    return call.summary()->seconds();
  }
  double WhileReceiving() {
    return Cancel([&](RawCall& call) { call.SendPoints(cloud_, 0, cloud_.size() / 2); });
  }
  double AfterHalfClose(double seconds) {
    return Cancel([&](RawCall& call) {
      call.SendCloud(cloud_);
      call.HalfClose();
      std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    });
  }
  double WhileSending() {
    return Cancel([&](RawCall& call) {
      call.SendCloud(cloud_);
      call.HalfClose();
      call.ReadFirstResult();
    });
  }

 private:
  template <typename Prepare>
  double Cancel(const Prepare& prepare) {
    RawCall call(OwnChannel(curvd_.address()));
    call.SendHeader(header_);
    prepare(call);
    call.Cancel();
    const double quiet = MillisecondsUntilQuiet(curvd_);
    call.Finish();
    curvd_.WaitUntilIdle();
    return quiet;
  }

  const CurvdChild& curvd_;
  const FaultCloud& cloud_;
  const v1::CloudHeader header_;
};

// Prints a row for each estimator; returns the longest time.
double MeasureLatencies(const CurvdChild& curvd, size_t points) {
  constexpr double kParts[] = {0.1, 0.5, 0.9};
  const FaultCloud cloud(points, 4);
  double longest = 0.0;
  const auto most = [&longest](double& cell, double milliseconds) {
    cell = std::max(cell, milliseconds);
    longest = std::max(longest, milliseconds);
  };
  std::printf("\n| milliseconds from cancel to quiet | receiving | index | estimate | sending | K = 10,000 |\n");
  std::printf("| --- | --: | --: | --: | --: | --: |\n");
  for (const v1::Estimator estimator : kEstimators) {
    v1::CloudHeader header;
    header.set_point_count(points);
    header.mutable_options()->set_estimator(estimator);
    CancelTimes usual(curvd, cloud, header);
    const v1::PhaseSeconds seconds = usual.Undisturbed();
    header.mutable_options()->set_neighbor_count(10'000);
    header.mutable_options()->set_triangle_count(10'000);
    header.mutable_options()->set_jet_degree(4);
    CancelTimes heavy(curvd, cloud, header);
    double receiving = 0, index = 0, estimate = 0, sending = 0, heaviest = 0;
    for (const double part : kParts) {
      most(receiving, usual.WhileReceiving());
      most(index, usual.AfterHalfClose(part * seconds.index()));
      most(estimate, usual.AfterHalfClose(seconds.index() + part * seconds.estimate()));
      most(sending, usual.WhileSending());
      most(heaviest, heavy.AfterHalfClose(seconds.index() + 0.2 + part));
    }
    std::printf("| %s | %.0f | %.0f | %.0f | %.0f | %.0f |\n", v1::Estimator_Name(estimator).c_str(), receiving, index,
                estimate, sending, heaviest);
    std::fflush(stdout);
  }
  return longest;
}

int Main(int argc, char** argv) {
  Flags flags;
  CLI::App app("Cancels many calls, and looks for what they leave behind", "fault_cancels");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--cancels", flags.cancels)->capture_default_str();
  app.add_option("--points", flags.points, "of the cloud whose cancels are timed; 0: none are")->capture_default_str();
  app.add_option("--limit-ms", flags.limit_ms, "more than this from cancel to quiet is a finding")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const CurvdChild curvd(flags.curvd, {"--log=false", "--threads=2", "--memory-limit=1GiB"});
  LookForLeftovers(curvd, flags.cancels);
  if (flags.points == 0) return 0;
  const double longest = MeasureLatencies(curvd, flags.points);
  if (longest > flags.limit_ms) Fail(absl::StrCat(longest, " ms from a cancel to quiet"));
  return 0;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
