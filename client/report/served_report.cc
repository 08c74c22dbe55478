#include "client/report/served_report.h"

#include <utility>

namespace curv {

void GrowingBytes::Append(std::string bytes) {
  {
    const std::lock_guard lock(mutex_);
    size_ += bytes.size();
    pieces_.push_back(std::move(bytes));
  }
  grown_.notify_all();
}

std::string_view GrowingBytes::Read(size_t offset, const std::stop_token& stop) const {
  if (offset >= total_) return {};
  std::unique_lock lock(mutex_);
  if (!grown_.wait(lock, stop, [this, offset] { return size_ > offset; })) return {};
  for (const std::string& piece : pieces_) {
    if (offset < piece.size()) return std::string_view(piece).substr(offset);
    offset -= piece.size();
  }
  return {};
}

void ReportShelf::Put(ServedReport report) {
  auto shared = std::make_shared<const ServedReport>(std::move(report));
  {
    const std::lock_guard lock(mutex_);
    report_ = std::move(shared);
  }
  put_.notify_all();
}

std::shared_ptr<const ServedReport> ReportShelf::Get() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

bool ReportShelf::AwaitFirst(const std::stop_token& stop) const {
  std::unique_lock lock(mutex_);
  return put_.wait(lock, stop, [this] { return report_ != nullptr; });
}

}  // namespace curv
