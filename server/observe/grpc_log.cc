#include "server/observe/grpc_log.h"

#include <grpc/support/log.h>

#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace curvd {

// The taps of this process: gRPC's log is one for all servers in it.
struct GrpcLogTaps {
  static GrpcLogTaps& Get() {
    static auto* taps = new GrpcLogTaps;  // never destroyed: gRPC may write until the process ends
    return *taps;
  }

  static void OnLine(gpr_log_func_args* line) {
    std::string file = line->file;
    file.erase(0, file.rfind('/') + 1);
    GrpcLogTaps& taps = Get();
    MutexLock lock(taps.mutex);
    for (const GrpcLogTap* tap : taps.open) tap->listener_(file, line->message, line->severity >= taps.shown);
  }

  Mutex mutex;
  std::vector<const GrpcLogTap*> open ABSL_GUARDED_BY(mutex);
  gpr_log_severity shown ABSL_GUARDED_BY(mutex) = GPR_LOG_SEVERITY_ERROR;  // what gRPC would have printed
};

GrpcLogTap::GrpcLogTap(Listener listener) : listener_(std::move(listener)) {
  GrpcLogTaps& taps = GrpcLogTaps::Get();
  MutexLock lock(taps.mutex);
  if (taps.open.empty()) {
    taps.shown = gpr_should_log(GPR_LOG_SEVERITY_DEBUG)  ? GPR_LOG_SEVERITY_DEBUG
                 : gpr_should_log(GPR_LOG_SEVERITY_INFO) ? GPR_LOG_SEVERITY_INFO
                                                         : GPR_LOG_SEVERITY_ERROR;
    gpr_set_log_function(GrpcLogTaps::OnLine);
    gpr_set_log_verbosity(GPR_LOG_SEVERITY_DEBUG);
  }
  taps.open.push_back(this);
}

GrpcLogTap::~GrpcLogTap() {
  GrpcLogTaps& taps = GrpcLogTaps::Get();
  MutexLock lock(taps.mutex);
  std::erase(taps.open, this);
  if (!taps.open.empty()) return;
  gpr_set_log_verbosity(taps.shown);
  gpr_set_log_function(nullptr);
}

}  // namespace curvd
