// What one caller has to suffer from others: from a flood of calls, and from memory that is held for nothing. Prints a
// row for each trial.
//
//   fault_callers --curvd=PATH [--times=20] [--flood=60]
// Ends with status 1 if a caller has to wait longer than is promised.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/raw_call.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using Clock = std::chrono::steady_clock;

constexpr double kAllowedRatio = 5.0;
constexpr int kCallsATime = 25;
constexpr auto kLongestTrial = std::chrono::minutes(2);

struct Flags {
  std::string curvd;
  int times = 20;
  int flood = 60;
};

// Two callers; whoever lists them in a token file shares nothing between them.
constexpr char kTokenLines[] =
    "alice sha256:19c28a50b1a09097592e7ceddb7e0771ff4d469747541a7536579eef857e05ce\n"
    "bob sha256:800480042268218663feef3ea54d81ed3f976c98c38d5fd7afbe22810ec16334\n"
    "carol sha256:7efa3d541f0c00bd394d267ad3e2b99c0870ce0bd7dcadb9f89a82aa8de48941\n";

// A directory with the file of tokens, removed at the end.
class TokenFile {
 public:
  TokenFile() : directory_(std::filesystem::temp_directory_path() / absl::StrCat("fault-callers-", getpid())) {
    std::filesystem::create_directory(directory_);
    std::ofstream(path()) << kTokenLines;
  }
  ~TokenFile() { std::filesystem::remove_all(directory_); }
  std::string path() const { return directory_ / "tokens"; }

 private:
  const std::filesystem::path directory_;
};

// Connections of one caller.
struct Caller {
  std::string token;
  std::shared_ptr<grpc::Channel> channel;

  std::unique_ptr<RawCall> Call() const {
    auto call = std::make_unique<RawCall>(channel);
    call->context().AddMetadata("authorization", "Bearer token-of-" + token);
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

double MedianOfCalls(const Caller& caller, const FaultCloud& cloud) {
  std::vector<double> seconds;
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < kCallsATime && Clock::now() < start + kLongestTrial; ++i) {
    seconds.push_back(TimeCall(caller, cloud));
  }
  return Median(std::move(seconds));
}

void WaitUntil(const std::function<bool()>& condition) {
  const Clock::time_point start = Clock::now();
  while (!condition()) {
    if (Clock::now() > start + kLongestTrial) Fail("the other callers do not get so far");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
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

struct Row {
  std::vector<double> idle, beside;
};

// Prints the row; returns whether it keeps what is promised.
bool Print(const char* name, const Row& row, double allowed_ratio) {
  std::vector<double> ratios;
  for (size_t i = 0; i < row.beside.size(); ++i) ratios.push_back(row.beside[i] / row.idle[i]);
  const double ratio = Median(ratios);
  std::printf("| %s | %zu | %.1f | %.1f | %.1f | %.1f | %.1f |\n", name, row.beside.size(), 1e3 * Median(row.idle),
              1e3 * Median(row.beside), 1e3 * *std::max_element(row.beside.begin(), row.beside.end()), ratio,
              allowed_ratio);
  std::fflush(stdout);
  return ratio <= allowed_ratio;
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
  Row row;
  for (int i = 0; i < flags.times; ++i) {
    row.idle.push_back(MedianOfCalls(bob, small));
    {
      const Flood flood(alice, flags.flood, expensive, large);
      WaitUntil([&] {
        return curvd.Metric("curvd_streams_open") >= flags.flood &&
               curvd.Metric("curvd_queue_jobs{queue=\"workers\"}") >= flags.flood / 2;
      });
      row.beside.push_back(MedianOfCalls(bob, small));
    }
    curvd.WaitUntilIdle();
  }
  return Print("1,000 points beside 60 calls of 100,000 points at K = 1,000", row, kAllowedRatio);
}

int Main(int argc, char** argv) {
  Flags flags;
  CLI::App app("What one caller has to suffer from others", "fault_callers");
  app.add_option("--curvd", flags.curvd)->required();
  app.add_option("--times", flags.times)->capture_default_str();
  app.add_option("--flood", flags.flood, "calls that the other has open")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "| one caller's call, beside another caller | times | idle ms | beside ms | longest ms | times as long | "
      "allowed |\n| --- | --: | --: | --: | --: | --: | --: |\n");
  bool all_well = FloodOfWork(flags);
  return all_well ? 0 : 1;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
