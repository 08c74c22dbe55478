// Writes the structured log: one JSON object a line, on stderr.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/observe/json_line.h"
#include "server/observe/log_rate_limit.h"
#include "server/rpc/call_record.h"

namespace curvd {

// Writing happens on a thread of the log's own: a stderr that nobody reads costs the oldest lines, never a call's time.
// Thread-safe.
class ServerLog {
 public:
  enum class Level { kInfo, kWarning, kError };

  // `calls`: whether LogCall writes anything.
  explicit ServerLog(bool calls);
  // Writes what is left.
  ~ServerLog();
  ServerLog(const ServerLog&) = delete;
  ServerLog& operator=(const ServerLog&) = delete;

  // Writes `line` with time, level and `event` put before it.
  void Log(Level level, const char* event, const JsonLine& line);
  // Writes the line of a call that is over. Its level is error for a defect of ours, warning for other failures. Of
  // calls that nobody let in there are LogRateLimit::kLinesPerSecond lines a second at most, and the next one tells how
  // many were left out.
  void LogCall(const CallRecord& record);

  // Lines that were dropped so far because stderr was not read, or did not take them.
  uint64_t lines_lost() const;

 private:
  struct Writer;
  const bool calls_;
  LogRateLimit refused_limit_;  // of calls that nobody let in
  std::unique_ptr<Writer> writer_;
};

// Returns what a call's line says, without time, level and event.
JsonLine CallLine(const CallRecord& record);

}  // namespace curvd
