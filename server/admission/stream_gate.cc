#include "server/admission/stream_gate.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {

absl::Status StreamGate::Open(const std::shared_ptr<OpenStream>& stream, const Caller& caller) {
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
  const size_t allowed = caller.max_streams == 0 ? max_streams_per_peer_ : caller.max_streams;
  const auto open = open_by_name_.find(caller.name);
  if (open != open_by_name_.end() && open->second >= allowed) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        {kReasonPeerStreamLimit, absl::StrCat("number of open calls of ", caller.name), absl::StrCat(open->second),
         absl::StrCat("below ", allowed, " (max_streams_per_peer) for one more"), absl::Seconds(1)});
  }
  const size_t own = open == open_by_name_.end() ? 0 : open->second;
  const size_t free = max_streams_ - streams_.size();
  const bool is_alone = open_by_name_.size() == (own > 0 ? 1 : 0);
  if (!is_alone && own >= kCallsPerFreePlace * free) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     {kReasonPeerStreamLimit, absl::StrCat("number of open calls of ", caller.name), absl::StrCat(own),
                      absl::StrCat("below ", kCallsPerFreePlace * free, ", which is ", kCallsPerFreePlace,
                                   " for each place that is free (max_streams), while others have calls open"),
                      absl::Seconds(1)});
  }
  streams_.emplace(stream.get(), Entry{stream, caller});
  ++open_by_name_[caller.name];
  return absl::OkStatus();
}

void StreamGate::FreePlace(Entry& entry) {
  if (!std::exchange(entry.holds_place, false)) return;
  const auto open = open_by_name_.find(entry.caller.name);
  if (--open->second == 0) open_by_name_.erase(open);
}

void StreamGate::FreePlace(const OpenStream* stream) {
  MutexLock lock(mutex_);
  if (const auto entry = streams_.find(stream); entry != streams_.end()) FreePlace(entry->second);
}

void StreamGate::Close(const OpenStream* stream) {
  MutexLock lock(mutex_);
  const auto entry = streams_.find(stream);
  if (entry == streams_.end()) return;
  FreePlace(entry->second);
  streams_.erase(entry);
  if (streams_.empty()) emptied_.NotifyAll();
}

void StreamGate::EndWhere(const std::function<absl::Status(const Caller&)>& verdict) {
  std::vector<std::pair<std::shared_ptr<OpenStream>, absl::Status>> ending;
  {
    MutexLock lock(mutex_);
    for (const auto& [key, entry] : streams_) {
      absl::Status status = verdict(entry.caller);
      if (status.ok()) continue;
      if (auto stream = entry.stream.lock()) ending.emplace_back(std::move(stream), std::move(status));
    }
  }
  for (auto& [stream, status] : ending) stream->Abort(std::move(status));
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
  for (const auto& [key, entry] : streams_) {
    if (std::shared_ptr<OpenStream> stream = entry.stream.lock()) open.push_back(std::move(stream));
  }
  return open;
}

}  // namespace curvd
