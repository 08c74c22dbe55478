#include "server/observe/grpc_log.h"

#include <grpc/support/log.h>

#include <string>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/observe/log_rate_limit.h"

namespace curvd {
namespace {

// Where gRPC's lines go: its log is one for the whole process.
struct Destination {
  Mutex mutex;
  ServerLog* log ABSL_GUARDED_BY(mutex) = nullptr;
  LogRateLimit limit;
};

Destination& TheDestination() {
  static auto* destination = new Destination;  // never destroyed: gRPC may write until the process ends
  return *destination;
}

ServerLog::Level LevelOf(gpr_log_severity severity) {
  return severity == GPR_LOG_SEVERITY_ERROR ? ServerLog::Level::kWarning : ServerLog::Level::kInfo;
}

void Write(gpr_log_func_args* line) {
  Destination& destination = TheDestination();
  uint64_t left_out = 0;
  if (!destination.limit.MayWrite(LogRateLimit::Clock::now(), left_out)) return;
  const std::string file = line->file;
  JsonLine json;
  json.Add("source", file.substr(file.rfind('/') + 1)).Add("message", line->message);
  if (left_out > 0) json.Add("lines_left_out", left_out);
  MutexLock lock(destination.mutex);
  if (destination.log != nullptr) destination.log->Log(LevelOf(line->severity), "grpc", json);
}

void SetLog(ServerLog* log) {
  MutexLock lock(TheDestination().mutex);
  TheDestination().log = log;
}

}  // namespace

GrpcLogRoute::GrpcLogRoute(ServerLog& log) {
  SetLog(&log);
  gpr_set_log_function(Write);
}

GrpcLogRoute::~GrpcLogRoute() {
  gpr_set_log_function(nullptr);
  SetLog(nullptr);
}

}  // namespace curvd
