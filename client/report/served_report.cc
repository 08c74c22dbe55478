#include "client/report/served_report.h"

#include <utility>

#include "absl/time/time.h"

namespace curv {

namespace {

constexpr absl::Duration kBetweenLooks = absl::Milliseconds(100);

}  // namespace

void GrowingBytes::Append(std::string bytes) {
  const absl::MutexLock lock(&mutex_);
  size_ += bytes.size();
  pieces_.push_back(std::move(bytes));
}

std::string_view GrowingBytes::Read(size_t offset, const std::stop_token& stop) const {
  if (offset >= total_) return {};
  const absl::MutexLock lock(&mutex_);
  const auto is_there = [this, offset]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return size_ > offset; };
  while (!mutex_.AwaitWithTimeout(absl::Condition(&is_there), kBetweenLooks)) {
    if (stop.stop_requested()) return {};
  }
  for (const std::string& piece : pieces_) {
    if (offset < piece.size()) return std::string_view(piece).substr(offset);
    offset -= piece.size();
  }
  return {};
}

void ReportShelf::Put(ServedReport report) {
  auto shared = std::make_shared<const ServedReport>(std::move(report));
  const absl::MutexLock lock(&mutex_);
  report_ = std::move(shared);
}

std::shared_ptr<const ServedReport> ReportShelf::Get() const {
  const absl::MutexLock lock(&mutex_);
  return report_;
}

bool ReportShelf::AwaitFirst(const std::stop_token& stop) const {
  const absl::MutexLock lock(&mutex_);
  const auto is_there = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return report_ != nullptr; };
  while (!mutex_.AwaitWithTimeout(absl::Condition(&is_there), kBetweenLooks)) {
    if (stop.stop_requested()) return false;
  }
  return true;
}

}  // namespace curv
