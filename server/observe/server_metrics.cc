#include "server/observe/server_metrics.h"

#include <prometheus/collectable.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/cpu_kind.h"
#include "server/host/version.h"
#include "server/observe/process_metrics.h"
#include "server/observe/scrape_builder.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"
#include "server/rpc/grpc_status.h"

namespace curvd {
namespace {

using prometheus::Counter;
using prometheus::Histogram;
using prometheus::Labels;
using prometheus::Registry;

constexpr int kCodeEnd = 17;  // one past grpc::StatusCode's UNAUTHENTICATED
// A phase as its label names it, and its time.
struct Phase {
  const char* name;
  std::optional<double> PhaseTimes::*time;
};
constexpr Phase kPhases[] = {{"receive", &PhaseTimes::receive},   {"admit", &PhaseTimes::admit},
                             {"queue", &PhaseTimes::queue},       {"index", &PhaseTimes::index},
                             {"normals", &PhaseTimes::normals},   {"orientation", &PhaseTimes::orientation},
                             {"estimate", &PhaseTimes::estimate}, {"send", &PhaseTimes::send}};

Histogram::BucketBoundaries SecondsBuckets() {
  return {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 120, 300, 600};
}

Histogram::BucketBoundaries PointsBuckets() { return {1e2, 1e3, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 3e7, 1e8}; }

prometheus::Family<Counter>& Counters(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

prometheus::Family<Histogram>& Histograms(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

// The gauges and what others count.
class StateReader : public prometheus::Collectable {
 public:
  explicit StateReader(std::function<ServerGauges()> read) : read_(std::move(read)) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    const ServerGauges gauges = read_();
    ScrapeBuilder scrape;
    constexpr char kQueue[] = "curvd_queue_jobs", kQueueHelp[] = "Calls that wait, by what they wait for.";
    scrape.AddGauge(kQueue, kQueueHelp, static_cast<double>(gauges.jobs_waiting_for_memory), {{"queue", "memory"}});
    scrape.AddGauge(kQueue, kQueueHelp, static_cast<double>(gauges.jobs_waiting_for_workers), {{"queue", "workers"}});
    scrape.AddGauge("curvd_queue_limit_jobs", "Calls that may wait for memory before further ones are refused.",
                    static_cast<double>(gauges.waiting_limit));
    scrape.AddGauge("curvd_workers", "Worker threads that all calls share.", static_cast<double>(gauges.workers));
    scrape.AddGauge("curvd_workers_busy", "Worker threads that run a work block now.",
                    static_cast<double>(gauges.workers_busy));
    scrape.AddGauge("curvd_memory_reserved_bytes", "Bytes that open calls have reserved.",
                    static_cast<double>(gauges.memory_reserved_bytes));
    scrape.AddGauge("curvd_memory_limit_bytes", "Bytes that open calls may reserve together.",
                    static_cast<double>(gauges.memory_limit_bytes));
    scrape.AddGauge("curvd_streams_open", "EstimateCurvature calls that are open.",
                    static_cast<double>(gauges.streams_open));
    scrape.AddGauge("curvd_streams_limit", "EstimateCurvature calls that may be open before further ones are refused.",
                    static_cast<double>(gauges.streams_limit));
    scrape.AddGauge("curvd_draining", "1 once the server has begun to drain.", gauges.draining ? 1.0 : 0.0);
    scrape.AddCounter("curvd_log_lines_lost_total",
                      "Log lines that were dropped because nobody read them in time, or that stderr did not take.",
                      static_cast<double>(gauges.log_lines_lost));
    return scrape.TakeFamilies();
  }

 private:
  const std::function<ServerGauges()> read_;
};

// The grpc_server_* series of one method.
struct MethodMetrics {
  MethodMetrics(Registry& registry, const char* type, const char* method)
      : started(Add(Counters(registry, "grpc_server_started_total", "RPCs started."), type, method)),
        received(Add(Counters(registry, "grpc_server_msg_received_total", "Messages received."), type, method)),
        sent(Add(Counters(registry, "grpc_server_msg_sent_total", "Messages sent."), type, method)),
        seconds(Histograms(registry, "grpc_server_handling_seconds", "Time from start to end of an RPC.")
                    .Add(MethodLabels(type, method), SecondsBuckets())) {
    // All codes from the start, as other gRPC servers have them: Prometheus cannot see the first error of a series that
    // appears with it.
    auto& family = Counters(registry, "grpc_server_handled_total", "RPCs completed, by code.");
    for (int code = 0; code < kCodeEnd; ++code) {
      Labels labels = MethodLabels(type, method);
      labels["grpc_code"] = CodeName(static_cast<absl::StatusCode>(code));
      handled[code] = &family.Add(labels);
    }
  }
  static Labels MethodLabels(const char* type, const char* method) {
    return {{"grpc_type", type}, {"grpc_service", "curvature.v1.CurvatureService"}, {"grpc_method", method}};
  }
  static Counter& Add(prometheus::Family<Counter>& family, const char* type, const char* method) {
    return family.Add(MethodLabels(type, method));
  }

  Counter& started;
  Counter& received;
  Counter& sent;
  Histogram& seconds;
  std::array<Counter*, kCodeEnd> handled;
};

}  // namespace

struct ServerMetrics::Families {
  explicit Families(std::function<ServerGauges()> read_gauges)
      : collectables{registry, std::make_shared<StateReader>(std::move(read_gauges)),
                     std::make_shared<ProcessMetrics>()} {
    for (const RpcMethodNames& names : kRpcMethods) methods.emplace_back(*registry, names.type, names.name);
    auto& points_family = Counters(*registry, "curvd_points_total", "Points estimated, by status.");
    for (int status = 1; status < kPointStatusEnd; ++status) {
      points[status] = &points_family.Add({{"status", PointStatusName(static_cast<PointStatus>(status))}});
    }
    auto& phase_family =
        Histograms(*registry, "curvd_phase_seconds", "Time that calls spend in each phase that they come to.");
    for (size_t i = 0; i < phases.size(); ++i)
      phases[i] = &phase_family.Add({{"phase", kPhases[i].name}}, SecondsBuckets());
    auto& failure_family = Counters(*registry, "curvd_failures_total", "Calls that failed, by reason.");
    for (const char* reason : kAllReasons) failures[reason] = &failure_family.Add({{"reason", reason}});
    prometheus::BuildGauge()
        .Name("curvd_build_info")
        .Help("Always 1; the labels tell what runs.")
        .Register(*registry)
        .Add({{"version", Version()}, {"cpu_kind", CpuKind()}})
        .Set(1.0);
  }

  std::shared_ptr<Registry> registry = std::make_shared<Registry>(Registry::InsertBehavior::Merge);
  std::vector<std::shared_ptr<prometheus::Collectable>> collectables;
  std::vector<MethodMetrics> methods;  // by RpcMethod
  Counter& received_bytes =
      Counters(*registry, "curvd_received_bytes_total", "Bytes of messages received, before HTTP/2 framing.").Add({});
  Counter& sent_bytes =
      Counters(*registry, "curvd_sent_bytes_total", "Bytes of messages sent, before HTTP/2 framing.").Add({});
  Histogram& cloud_points = Histograms(*registry, "curvd_cloud_points", "Points of the clouds whose calls succeeded.")
                                .Add({}, PointsBuckets());
  std::array<Counter*, kPointStatusEnd> points{};
  std::array<Histogram*, std::size(kPhases)> phases{};
  std::map<std::string, Counter*> failures;
};

ServerMetrics::ServerMetrics(std::function<ServerGauges()> read_gauges)
    : families_(std::make_unique<Families>(std::move(read_gauges))) {}

ServerMetrics::~ServerMetrics() = default;

void ServerMetrics::CountStarted(RpcMethod method) {
  families_->methods[static_cast<size_t>(method)].started.Increment();
}

void ServerMetrics::CountReceived(RpcMethod method, uint64_t bytes) {
  families_->methods[static_cast<size_t>(method)].received.Increment();
  families_->received_bytes.Increment(static_cast<double>(bytes));
}

void ServerMetrics::CountSent(RpcMethod method, uint64_t bytes) {
  families_->methods[static_cast<size_t>(method)].sent.Increment();
  families_->sent_bytes.Increment(static_cast<double>(bytes));
}

void ServerMetrics::CountHandled(RpcMethod method, absl::StatusCode code, double seconds) {
  MethodMetrics& metrics = families_->methods[static_cast<size_t>(method)];
  metrics.handled[static_cast<size_t>(code) % kCodeEnd]->Increment();
  metrics.seconds.Observe(seconds);
}

void ServerMetrics::CountCall(const CallRecord& record) {
  for (int status = 1; status < kPointStatusEnd; ++status) {
    if (record.status_counts[status] > 0) families_->points[status]->Increment(record.status_counts[status]);
  }
  for (size_t i = 0; i < families_->phases.size(); ++i) {
    const std::optional<double>& time = record.seconds.*kPhases[i].time;
    if (time.has_value()) families_->phases[i]->Observe(*time);
  }
  if (!record.status.ok()) {
    const auto found = families_->failures.find(ReasonOf(record.status));
    (found == families_->failures.end() ? families_->failures[kReasonInternal] : found->second)->Increment();
    return;
  }
  if (record.method != RpcMethod::kEstimateCurvature) return;
  families_->cloud_points.Observe(static_cast<double>(record.points_received));
}

const std::vector<std::shared_ptr<prometheus::Collectable>>& ServerMetrics::collectables() const {
  return families_->collectables;
}

}  // namespace curvd
