#include "server/stream_gate.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/error_detail.h"
#include "server/reasons.h"

namespace curvd {

absl::Status StreamGate::Open(const std::shared_ptr<OpenStream>& stream) {
  MutexLock lock(mutex_);
  if (draining_) {
    return WithDetail(absl::UnavailableError("the server is draining and takes no new calls; use another replica"),
                      {kReasonDraining, "server", "draining", "", {}});
  }
  if (streams_.size() >= max_streams_) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     {kReasonStreamLimit, "number of open calls", absl::StrCat(streams_.size()),
                      absl::StrCat("below ", max_streams_, " (max_streams) for one more"), absl::Seconds(1)});
  }
  streams_.emplace(stream.get(), stream);
  return absl::OkStatus();
}

void StreamGate::Close(const OpenStream* stream) {
  MutexLock lock(mutex_);
  streams_.erase(stream);
  if (streams_.empty()) emptied_.NotifyAll();
}

void StreamGate::StartDraining() {
  MutexLock lock(mutex_);
  draining_ = true;
}

bool StreamGate::draining() const {
  MutexLock lock(mutex_);
  return draining_;
}

bool StreamGate::WaitUntilEmpty(absl::Duration timeout) {
  // Beyond this the clock would overflow; a year is as good as for ever.
  const absl::Duration bounded = std::min(timeout, absl::Hours(24 * 365));
  const auto deadline = std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(bounded);
  MutexLock lock(mutex_);
  while (!streams_.empty()) {
    if (!emptied_.WaitUntil(mutex_, deadline)) return streams_.empty();
  }
  return true;
}

size_t StreamGate::open_count() const {
  MutexLock lock(mutex_);
  return streams_.size();
}

std::vector<std::shared_ptr<OpenStream>> StreamGate::open_streams() const {
  std::vector<std::shared_ptr<OpenStream>> open;
  MutexLock lock(mutex_);
  open.reserve(streams_.size());
  for (const auto& [key, weak] : streams_) {
    if (std::shared_ptr<OpenStream> stream = weak.lock()) open.push_back(std::move(stream));
  }
  return open;
}

}  // namespace curvd
