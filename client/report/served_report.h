// Hands reports from the thread that makes them to those that serve them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>

namespace curv {

// Bytes that come one piece after the other, while others read them. Thread-safe.
class GrowingBytes {
 public:
  explicit GrowingBytes(size_t total) : total_(total) {}

  // How many there are to be.
  size_t total() const { return total_; }

  // Adds the next. REQUIRES: they are not empty, and no more than `total` come in all.
  void Append(std::string bytes);

  // Returns bytes from `offset` on, as far as they lie in one piece, once they are there. They stay where they are as
  // long as this does. Nothing at the end, or after a stop is requested.
  std::string_view Read(size_t offset, const std::stop_token& stop) const;

 private:
  const size_t total_;
  mutable std::condition_variable_any grown_;
  mutable std::mutex mutex_;  // guards what follows
  std::deque<std::string> pieces_;
  size_t size_ = 0;
};

// A report for the page of `curv view`.
struct ServedReport {
  uint64_t generation = 0;  // grows with each report of a file
  std::string report;       // JSON
  std::shared_ptr<const GrowingBytes> points;
};

// Holds the present report. Thread-safe.
class ReportShelf {
 public:
  // Takes the place of the report before.
  void Put(ServedReport report);
  // Returns the present report, or null before the first.
  std::shared_ptr<const ServedReport> Get() const;
  // Waits for the first report. Returns false if a stop is requested before.
  bool AwaitFirst(const std::stop_token& stop) const;

 private:
  mutable std::condition_variable_any put_;
  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<const ServedReport> report_;
};

}  // namespace curv
