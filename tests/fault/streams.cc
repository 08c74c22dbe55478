// Opens many calls at once, and checks that each is answered right or refused with a time to wait, and that the server
// keeps to its memory limit meanwhile. With --idle, connections are idle before their calls begin, one after the other.
//
//   fault_streams --curvd=PATH [--streams=500] [--connections=100] [--memory-limit-mib=256] [--idle=0] [--metadata=0]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <latch>
#include <mutex>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/job/estimation_job.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/raw_call.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

struct Flags {
  std::string curvd;
  int streams = 500;
  int connections = 100;
  size_t points = 30'000;
  uint64_t memory_limit_mib = 256;
  double idle = 0.0;    // seconds until the last call begins; the first begins after half of them
  size_t metadata = 0;  // bytes that each call has beside its own
};

struct Case {
  FaultCloud cloud;
  v1::CloudHeader header;
  ResultDigest expected;
};

// One cloud with its size told and one without, since memory is reserved at once for the one and step by step for the
// other.
std::vector<Case> MakeCases(size_t points) {
  WorkerPool pool(2);
  std::vector<Case> cases;
  for (const bool size_is_known : {true, false}) {
    FaultCloud cloud(points, size_is_known ? 1 : 2);
    const auto result = EstimateCurvature(cloud.ToCloud(), {}, pool);
    if (!result.ok()) Fail("the direct computation fails");
    v1::CloudHeader header;
    if (size_is_known) header.set_point_count(points);
    cases.push_back({std::move(cloud), header, ResultDigest::Of(result->field)});
  }
  return cases;
}

bool HasRetryInfo(const grpc::Status& status) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return false;
  for (const google::protobuf::Any& detail : details.details()) {
    if (detail.Is<google::rpc::RetryInfo>()) return true;
  }
  return false;
}

struct Counts {
  std::atomic<int> right = 0;
  std::atomic<int> refused = 0;
  std::mutex mutex;
  std::string finding;           // guarded by mutex: the first
  double longest_seconds = 0.0;  // guarded by mutex: of a call
};

// One of all calls.
struct Turn {
  std::shared_ptr<grpc::Channel> channel;
  const Case& work;
  double idle;                   // seconds until it begins
  size_t metadata;               // bytes
  std::latch* opened = nullptr;  // not null: all open their call before any sends its cloud
};

void RunCall(const Turn& turn, Counts& counts) {
  absl::SleepFor(absl::Seconds(turn.idle));
  const absl::Time begin = absl::Now();
  const Case& work = turn.work;
  RawCall call(turn.channel);
  if (turn.metadata > 0) call.context().AddMetadata("x-filling", std::string(turn.metadata, 'x'));
  const bool open = call.SendHeader(work.header);
  if (turn.opened != nullptr) turn.opened->arrive_and_wait();
  if (open) call.SendCloud(work.cloud);
  call.HalfClose();
  const grpc::Status status = call.Finish();
  {
    const std::lock_guard lock(counts.mutex);
    counts.longest_seconds = std::max(counts.longest_seconds, absl::ToDoubleSeconds(absl::Now() - begin));
  }
  if (status.ok() && call.digest() == work.expected) {
    ++counts.right;
  } else if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED && HasRetryInfo(status)) {
    ++counts.refused;
  } else {
    const std::lock_guard lock(counts.mutex);
    counts.finding = status.ok() ? "a wrong byte" : absl::StrCat(status.error_code(), ": ", status.error_message());
  }
}

int Main(int argc, char** argv) {
  Flags flags;
  CLI::App app("Opens many calls at once", "fault_streams");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--streams", flags.streams)->capture_default_str();
  app.add_option("--connections", flags.connections, "that the calls share")->capture_default_str();
  app.add_option("--points", flags.points, "of each cloud")->capture_default_str();
  app.add_option("--memory-limit-mib", flags.memory_limit_mib)->capture_default_str();
  app.add_option("--idle", flags.idle,
                 "seconds until the last call begins, the first after half of them; 0: all at once")
      ->capture_default_str();
  app.add_option("--metadata", flags.metadata, "bytes that each call has beside its own")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const std::vector<Case> cases = MakeCases(flags.points);
  const CurvdChild curvd(flags.curvd,
                         {"--log=false", "--threads=2", absl::StrCat("--memory-limit=", flags.memory_limit_mib, "MiB"),
                          absl::StrCat("--max-connections-per-peer=", flags.connections + 1)});
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  for (int i = 0; i < flags.connections; ++i) {
    channels.push_back(OwnChannel(curvd.address()));
    if (!channels.back()->WaitForConnected(std::chrono::system_clock::now() + std::chrono::minutes(1))) {
      Fail("curvd takes no connection");
    }
  }
  Counts counts;
  std::latch opened(flags.streams);
  std::vector<std::thread> clients;
  clients.reserve(flags.streams);
  for (int i = 0; i < flags.streams; ++i) {
    const double idle = flags.idle * (0.5 + 0.5 * i / flags.streams);
    const Turn turn{channels[i % channels.size()], cases[i % cases.size()], idle, flags.metadata,
                    flags.idle > 0.0 ? nullptr : &opened};
    clients.emplace_back([turn, &counts] { RunCall(turn, counts); });
  }
  for (std::thread& client : clients) client.join();
  if (!counts.finding.empty()) Fail(counts.finding);
  curvd.WaitUntilIdle();
  const uint64_t peak_mib = curvd.Usage().peak_bytes >> 20;
  std::printf(
      "| streams at once | connections | right | refused with RetryInfo | longest s | peak MiB | limit MiB |\n"
      "| --: | --: | --: | --: | --: | --: | --: |\n| %d | %d | %d | %d | %.1f | %d | %d |\n",
      flags.streams, flags.connections, counts.right.load(), counts.refused.load(), counts.longest_seconds,
      static_cast<int>(peak_mib), static_cast<int>(flags.memory_limit_mib));
  if (peak_mib > flags.memory_limit_mib) Fail("more memory than the limit");
  return 0;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
