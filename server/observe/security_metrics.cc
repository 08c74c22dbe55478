#include "server/observe/security_metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>

#include <array>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {
namespace {

constexpr const char* kReasonNames[kStrangerReasonCount] = {
    "connection_limit", "peer_connection_limit", "no_descriptor",     "handshake_timeout", "nothing_sent", "no_call",
    "not_let_in",       "unaccounted_bytes",     "too_much_metadata", "memory_short"};

// Counted when it is asked for, so that it is never stale.
class OpenConnections : public prometheus::Collectable {
 public:
  void ReadFrom(std::function<size_t()> open) {
    MutexLock lock(mutex_);
    open_ = std::move(open);
  }

  std::vector<prometheus::MetricFamily> Collect() const override {
    MutexLock lock(mutex_);
    if (!open_) return {};
    prometheus::MetricFamily family;
    family.name = "curvd_connections_open";
    family.help = "Connections to the port that takes calls.";
    family.type = prometheus::MetricType::Gauge;
    family.metric.emplace_back().gauge.value = static_cast<double>(open_());
    return {std::move(family)};
  }

 private:
  mutable Mutex mutex_;
  std::function<size_t()> open_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

const char* StrangerReasonName(StrangerReason reason) { return kReasonNames[static_cast<size_t>(reason)]; }

struct SecurityMetrics::Families {
  Families() : collectables{registry, connections} {
    auto& strangers_family =
        prometheus::BuildCounter()
            .Name("curvd_strangers_total")
            .Help("Connections that were closed at once, or ended without a call that was let in, by reason.")
            .Register(*registry);
    for (size_t i = 0; i < kStrangerReasonCount; ++i) {
      strangers[i] = &strangers_family.Add({{"reason", kReasonNames[i]}});
    }
  }

  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  std::shared_ptr<OpenConnections> connections = std::make_shared<OpenConnections>();
  std::vector<std::shared_ptr<prometheus::Collectable>> collectables;
  std::array<prometheus::Counter*, kStrangerReasonCount> strangers{};
  prometheus::Family<prometheus::Counter>& reloads =
      prometheus::BuildCounter()
          .Name("curvd_credential_reloads_total")
          .Help("Times that a certificate, token or name file changed and was read again.")
          .Register(*registry);
  prometheus::Counter& reloads_ok = reloads.Add({{"result", "ok"}});
  prometheus::Counter& reloads_failed = reloads.Add({{"result", "failed"}});
  prometheus::Gauge& expiry = prometheus::BuildGauge()
                                  .Name("curvd_tls_certificate_expiry_timestamp_seconds")
                                  .Help("When the server's certificate ends, in Unix time; 0 without TLS.")
                                  .Register(*registry)
                                  .Add({});
};

SecurityMetrics::SecurityMetrics() : families_(std::make_unique<Families>()) {}
SecurityMetrics::~SecurityMetrics() = default;

void SecurityMetrics::CountStranger(StrangerReason reason) {
  families_->strangers[static_cast<size_t>(reason)]->Increment();
}

void SecurityMetrics::CountReload(bool ok) { (ok ? families_->reloads_ok : families_->reloads_failed).Increment(); }

void SecurityMetrics::SetCertificateExpiry(absl::Time expires) {
  families_->expiry.Set(static_cast<double>(absl::ToUnixSeconds(expires)));
}

void SecurityMetrics::ReadConnectionsFrom(std::function<size_t()> open) {
  families_->connections->ReadFrom(std::move(open));
}

const std::vector<std::shared_ptr<prometheus::Collectable>>& SecurityMetrics::collectables() const {
  return families_->collectables;
}

}  // namespace curvd
