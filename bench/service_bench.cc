// What the service adds to the estimate: a load program that drives a curvd process over loopback.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

#include "absl/strings/str_cat.h"
#include "bench/clouds.h"
#include "bench/core_run.h"
#include "bench/flags.h"
#include "bench/raw_call.h"
#include "bench/server_process.h"
#include "bench/stopwatch.h"
#include "bench/table.h"
#include "bench/threads.h"
#include "client/curvature_client.h"
#include "core/base/page_pool.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {
namespace {

constexpr uint32_t kNeighbors = 50;

curv::CurvatureResult EstimateRemotely(const curv::CurvatureClient& client, const BenchCloud& cloud) {
  curv::EstimateOptions options;
  options.neighbor_count = kNeighbors;
  auto result = client.Estimate(curv::CloudView(cloud.positions, cloud.normals), options);
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().ToString().c_str());
    std::exit(1);
  }
  return *std::move(result);
}

std::unique_ptr<curv::CurvatureClient> ConnectTo(const ServerProcess& server) {
  auto client = curv::CurvatureClient::Connect(server.address());
  if (!client.ok()) std::exit(1);
  return *std::move(client);
}

EstimatorOptions LocalOptions() { return OptionsFor("avg-hexagram", kNeighbors, EstimatorOptions().rotation_count); }

// The service must return what the core computes, to the bit; ends the program otherwise.
void CheckSameResults(const CurvatureField& local, const curv::CurvatureResult& remote) {
  for (size_t i = 0; i < local.points.size(); ++i) {
    const PointCurvature& point = local.points[i];
    if (point.status == PointStatus::kOk && point.mean == remote.mean[i] && point.k1 == remote.k1[i]) continue;
    std::fprintf(stderr, "point %zu: the service's result is not the core's: the comparison is void\n", i);
    std::exit(1);
  }
}

// A process has its own luck with memory for as long as it lives: those that are measured start anew every few calls.
constexpr int kCallsPerProcess = 5;

// A server and a client that start anew so.
class FreshServer {
 public:
  // `start` makes a server; `expected` is what it must answer.
  FreshServer(std::function<ServerProcess()> start, const BenchCloud& cloud, const CurvatureField& expected)
      : start_(std::move(start)), cloud_(cloud), expected_(expected) {}

  // CPU seconds of a whole call, server and client.
  Figures MeasureCall() {
    if (calls_++ % kCallsPerProcess == 0) Restart();
    const double client_start = CpuSeconds(), server_start = server_->CpuSeconds();
    EstimateRemotely(*client_, cloud_);
    const double client_cpu = CpuSeconds() - client_start, server_cpu = server_->CpuSeconds() - server_start;
    return {{"total", client_cpu + server_cpu}, {"client", client_cpu}, {"server", server_cpu}};
  }

 private:
  void Restart() {
    client_.reset();
    server_.reset();
    server_.reset(new ServerProcess(start_()));
    client_ = ConnectTo(*server_);
    CheckSameResults(expected_, EstimateRemotely(*client_, cloud_));  // also warms the channel
  }

  const std::function<ServerProcess()> start_;
  const BenchCloud& cloud_;
  const CurvatureField& expected_;
  int calls_ = 0;
  std::unique_ptr<ServerProcess> server_;
  std::unique_ptr<curv::CurvatureClient> client_;
};

// The estimate in this process, with pages that an estimate before left, as a server has them.
Figures RunCoreOnKeptPages(const BenchCloud& cloud, WorkerPool& pool) {
  ProcessPages().SetLimits({.kept = size_t{1} << 30, .together = size_t{1} << 40});
  RunCore(cloud, LocalOptions(), pool);
  Figures figures = RunCore(cloud, LocalOptions(), pool);
  ProcessPages().SetLimits({});
  return figures;
}

// CPU time of the whole call, server and client, over that of the estimate in this process, and over that of the same
// call to a server that does nothing else.
void CompareWithInProcess(const Flags& flags, const BenchCloud& cloud, int threads, Table& table, Targets& targets) {
  WorkerPool pool(threads);
  CurvatureField field;
  RunCore(cloud, LocalOptions(), pool, &field);
  FreshServer server([threads] { return ServerProcess::Curvd(threads); }, cloud, field);
  FreshServer bare([threads] { return ServerProcess::Bare(threads); }, cloud, field);
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " ", threads, " threads"));
  comparison.Add("estimate", [&] { return RunCore(cloud, LocalOptions(), pool); });
  comparison.Add("estimate on kept pages", [&] { return RunCoreOnKeptPages(cloud, pool); });
  comparison.Add("arrays to field", [&] {
    const double start = CpuSeconds();
    RunCore(cloud, LocalOptions(), pool);
    return Figures{{"total", CpuSeconds() - start}};
  });
  comparison.Add("service", [&] { return server.MeasureCall(); });
  comparison.Add("bare service", [&] { return bare.MeasureCall(); });
  auto medians = comparison.Run(flags.RoundsOr(51));
  const auto micros = [&](const char* way, const char* figure = "total") {
    return 1e6 * medians[way][figure] / static_cast<double>(cloud.size());
  };
  const auto service_over = [&](const char* way) { return micros("service") / micros(way); };
  table.AddRow({absl::StrCat(cloud.size()), absl::StrCat(threads), Digits(micros("estimate")),
                Digits(micros("estimate on kept pages")), Digits(micros("arrays to field")),
                Digits(micros("service", "server")), Digits(micros("service", "client")), Digits(micros("service")),
                Digits(service_over("estimate")), Digits(service_over("estimate on kept pages")),
                Digits(service_over("arrays to field")), Digits(micros("bare service")),
                Digits(service_over("bare service"))});
  targets.AtMost(absl::StrCat("CPU of server and client over the in-process estimate; K=50; ", threads, " threads"),
                 1.15, service_over("estimate"), "x");
  targets.AtMost(absl::StrCat("the same over that of a bare server; ", threads, " threads"), 1.03,
                 service_over("bare service"), "x");
}

// Waits until the server has nothing left to do: its CPU clock stands still.
double SettledCpu(const ServerProcess& server) {
  constexpr auto kPause = std::chrono::milliseconds(100);
  double last = server.CpuSeconds();
  for (int still = 0; still < 3;) {
    std::this_thread::sleep_for(kPause);
    const double now = server.CpuSeconds();
    still = now - last < 1e-3 ? still + 1 : 0;
    last = now;
  }
  return last;
}

void MeasureIngest(const Flags& flags, const BenchCloud& cloud, Table& table, Targets& targets) {
  const ServerProcess server = ServerProcess::Curvd(1);
  const double megabytes = 1e-6 * sizeof(float) * static_cast<double>(cloud.positions.size() + cloud.normals.size());
  std::vector<double> rates, shared_rates;
  for (int round = 0; round < flags.RoundsOr(7); ++round) {
    RawCall call(server.address(), cloud, kNeighbors);
    const double start = SettledCpu(server), client_start = CpuSeconds();
    call.SendPoints();
    const double cpu = SettledCpu(server) - start;
    rates.push_back(megabytes / cpu);
    shared_rates.push_back(megabytes / (cpu + CpuSeconds() - client_start));
  }
  table.AddRow({absl::StrCat("ingest; ", cloud.size(), " points in float32; MB per CPU second of the server"),
                Digits(Median(rates))});
  table.AddRow({"the same; per CPU second of server and client", Digits(Median(shared_rates))});
  targets.AtLeast("ingest per CPU second of the server", 500.0, Median(rates), " MB");
}

// The waits of calls to a curvd that starts anew every other call: waits scatter more than CPU time does, and more from
// process to process than from call to call.
class WaitingCaller {
 public:
  WaitingCaller(int threads, const BenchCloud& cloud) : threads_(threads), cloud_(cloud) {}

  Figures MeasureCall() {
    if (calls_++ % 2 == 0) {
      server_.reset();
      server_.reset(new ServerProcess(ServerProcess::Curvd(threads_)));
      Call();  // warms it
    }
    const RawCall::Waits waits = Call();
    return {{"total", waits.summary}, {"first result", waits.first_result}, {"summary", waits.summary}};
  }

 private:
  RawCall::Waits Call() {
    RawCall call(server_->address(), cloud_, kNeighbors);
    call.SendPoints();
    SettledCpu(*server_);  // what was sent has arrived
    return call.FinishAndRead();
  }

  const int threads_;
  const BenchCloud& cloud_;
  int calls_ = 0;
  std::unique_ptr<ServerProcess> server_;
};

// From the half-close on, with one worker and with two, in turn.
void MeasureWaits(const Flags& flags, const BenchCloud& cloud, Table& table, Targets& targets) {
  SideBySide comparison(absl::StrCat(cloud.name, " ", cloud.size(), " half-close"));
  WaitingCaller one(1, cloud), two(2, cloud);
  comparison.Add("1", [&] { return one.MeasureCall(); });
  comparison.Add("2", [&] { return two.MeasureCall(); });
  comparison.Add("control 1", [] { return Spin(1); });
  comparison.Add("control 2", [] { return Spin(2); });
  auto medians = comparison.Run(flags.RoundsOr(101));
  for (const char* threads : {"1", "2"}) {
    for (const char* event : {"first result", "summary"}) {
      table.AddRow(
          {absl::StrCat("half-close to ", event, "; ", cloud.size(), " points; K=50; ", threads, " server threads; ms"),
           Digits(1e3 * medians[threads][event])});
    }
  }
  AddSpeedup("two threads over one; half-close to summary", medians["1"]["summary"] / medians["2"]["summary"],
             medians["control 1"]["wall"] / medians["control 2"]["wall"], targets);
}

// Both servers in turns, call by call.
void MeasureSmallCloud(const Flags& flags, Table& table, Targets& targets) {
  const ServerProcess server = ServerProcess::Curvd(1), bare = ServerProcess::Bare(1);
  const auto client = ConnectTo(server), bare_client = ConnectTo(bare);
  const BenchCloud cloud = SurfaceCloud("torus", 1'000, flags.clouds);
  const auto milliseconds_of = [&](const curv::CurvatureClient& caller) {
    const double start = WallSeconds();
    EstimateRemotely(caller, cloud);
    return 1e3 * (WallSeconds() - start);
  };
  std::vector<double> milliseconds, bare_milliseconds;
  const int warming = 20, calls = flags.quick ? 100 : 1'000;
  for (int i = 0; i < warming + calls; ++i) {
    const double ours = milliseconds_of(*client), theirs = milliseconds_of(*bare_client);
    if (i < warming) continue;
    milliseconds.push_back(ours);
    bare_milliseconds.push_back(theirs);
  }
  const std::string what = "round trip of 1000 points; warm channel; ms";
  table.AddRow({absl::StrCat(what, "; median of ", calls), Digits(Median(milliseconds))});
  table.AddRow({absl::StrCat(what, "; 99th percentile"), Digits(Quantile(milliseconds, 0.99))});
  table.AddRow({"the same of a bare server; median", Digits(Median(bare_milliseconds))});
  targets.AtMost("round trip of 1000 points; median", 2.0, Median(milliseconds), " ms");
}

void MeasureMemory(const Flags& flags, size_t points, Table& table, Targets& targets) {
  const BenchCloud cloud = SurfaceCloud("torus", points, flags.clouds);
  const ServerProcess server = ServerProcess::Curvd(2);
  const double idle = server.PeakBytes();
  const auto client = ConnectTo(server);
  EstimateRemotely(*client, cloud);
  const double peak = server.PeakBytes();
  table.AddRow({absl::StrCat("server's peak resident memory; ", points, " points; bytes a point"),
                Digits(peak / static_cast<double>(points))});
  table.AddRow({"the same; less what it holds when idle", Digits((peak - idle) / static_cast<double>(points))});
  // A small cloud says little: the process itself weighs more.
  if (flags.full)
    targets.AtMost("server's peak memory; bytes a point", 128.0, peak / static_cast<double>(points), " B");
}

void Main(const Flags& flags) {
  Table calls("service_cpu", {"points", "threads", "estimate us/point", "on kept pages us/point",
                              "arrays to field us/point", "server us/point", "client us/point",
                              "server + client us/point", "over estimate", "over estimate on kept pages",
                              "over arrays to field", "bare server + client us/point", "over bare server"});
  Table service("service", {"what", "measured"});
  Targets targets("service");
  const BenchCloud cloud = SurfaceCloud("torus", flags.quick ? 100'000 : 500'000, flags.clouds);
  for (int threads : {1, 2}) CompareWithInProcess(flags, cloud, threads, calls, targets);
  MeasureIngest(flags, SurfaceCloud("torus", flags.quick ? 300'000 : 3'000'000, flags.clouds), service, targets);
  MeasureWaits(flags, cloud, service, targets);
  MeasureSmallCloud(flags, service, targets);
  MeasureMemory(flags, flags.full ? 10'000'000 : flags.quick ? 300'000 : 3'000'000, service, targets);
  calls.Finish(flags.out);
  service.Finish(flags.out);
  targets.Finish(flags.out);
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  curvd::bench::Main(curvd::bench::ParseFlags(argc, argv, "What the service adds to the estimate, over loopback"));
}
