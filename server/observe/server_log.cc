#include "server/observe/server_log.h"

#include <spdlog/async.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cstdio>
#include <mutex>
#include <optional>
#include <utility>

#include "server/rpc/error_detail.h"
#include "server/rpc/grpc_status.h"

namespace curvd {
namespace {

constexpr size_t kQueuedLines = 8192;

spdlog::level::level_enum SpdlogLevel(ServerLog::Level level) {
  switch (level) {
    case ServerLog::Level::kInfo:
      return spdlog::level::info;
    case ServerLog::Level::kWarning:
      return spdlog::level::warn;
    case ServerLog::Level::kError:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

ServerLog::Level LevelOf(const absl::Status& status) {
  if (status.ok()) return ServerLog::Level::kInfo;
  return absl::IsInternal(status) ? ServerLog::Level::kError : ServerLog::Level::kWarning;
}

}  // namespace

struct ServerLog::Writer {
  // Writes lines to stderr, and counts those that it did not take, as where a file's disk is full.
  class Sink final : public spdlog::sinks::base_sink<std::mutex> {
   public:
    uint64_t lines_lost() const { return lines_lost_.load(std::memory_order_relaxed); }

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      spdlog::memory_buf_t line;
      formatter_->format(message, line);
      if (std::fwrite(line.data(), 1, line.size(), stderr) == line.size() && std::fflush(stderr) == 0) return;
      lines_lost_.fetch_add(1, std::memory_order_relaxed);
      std::clearerr(stderr);
    }
    void flush_() override {}

    std::atomic<uint64_t> lines_lost_ = 0;
  };

  Writer() { logger.set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v)", spdlog::pattern_time_type::utc); }
  // Goes after the thread, which writes to it.
  const std::shared_ptr<Sink> sink = std::make_shared<Sink>();
  std::shared_ptr<spdlog::details::thread_pool> thread =
      std::make_shared<spdlog::details::thread_pool>(kQueuedLines, 1);
  // Its lines go to the thread by shared_from_this.
  std::shared_ptr<spdlog::async_logger> shared =
      std::make_shared<spdlog::async_logger>("curvd", sink, thread, spdlog::async_overflow_policy::overrun_oldest);
  spdlog::async_logger& logger = *shared;
};

ServerLog::ServerLog(bool calls) : calls_(calls), writer_(std::make_unique<Writer>()) {}

ServerLog::~ServerLog() = default;

void ServerLog::Log(Level level, const char* event, const JsonLine& line) {
  std::string text = JsonLine().Add("event", event).str();
  const std::string rest = line.str();
  text.pop_back();
  if (rest.size() > 2) text += ',';
  text.append(rest, 1);
  writer_->logger.log(SpdlogLevel(level), spdlog::string_view_t(text.data() + 1, text.size() - 1));
}

void ServerLog::LogCall(const CallRecord& record) {
  if (!calls_) return;
  uint64_t left_out = 0;
  const bool was_refused = record.caller.empty() && !record.status.ok();
  if (was_refused && !refused_limit_.MayWrite(LogRateLimit::Clock::now(), left_out)) return;
  JsonLine line = CallLine(record);
  if (left_out > 0) line.Add("lines_left_out", left_out);
  Log(LevelOf(record.status), "call", line);
}

uint64_t ServerLog::lines_lost() const { return writer_->thread->overrun_counter() + writer_->sink->lines_lost(); }

JsonLine CallLine(const CallRecord& record) {
  JsonLine line;
  line.Add("request_id", record.request_id)
      .Add("method", NamesOf(record.method).name)
      .Add("tag", record.request_tag)
      .Add("peer", record.peer)
      .Add("caller", record.caller)
      .Add("code", CodeName(record.status.code()));
  if (!record.status.ok()) {
    line.Add("reason", ReasonOf(record.status)).Add("message", std::string(record.status.message()));
  }
  const PhaseTimes& seconds = record.seconds;
  line.Add("points", record.points_received)
      .Add("points_ok", record.status_counts[static_cast<size_t>(PointStatus::kOk)])
      .Add("received_bytes", record.bytes_received)
      .Add("sent_bytes", record.bytes_sent)
      .Add("peak_bytes", record.peak_bytes)
      .Add("seconds", record.total_seconds);
  const std::pair<const char*, std::optional<double>> phases[] = {
      {"receive_seconds", seconds.receive},   {"admit_seconds", seconds.admit},
      {"queue_seconds", seconds.queue},       {"index_seconds", seconds.index},
      {"normals_seconds", seconds.normals},   {"orientation_seconds", seconds.orientation},
      {"estimate_seconds", seconds.estimate}, {"send_seconds", seconds.send}};
  for (const auto& [name, time] : phases) {
    if (time.has_value()) line.Add(name, *time);
  }
  return line;
}

}  // namespace curvd
