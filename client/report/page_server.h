// Serves one page, and what it asks for, to browsers of this machine.
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/report/served_report.h"

namespace curv {

// Answers HTTP/1.1 (RFC 9110, RFC 9112) on 127.0.0.1: GET and HEAD of one path, which holds 128 random bits, so that no
// other user of the machine and no other page in the browser can ask for it. Requests with another host in them than
// this machine's are refused, whatever name leads here. Where there is a shelf, below the path also `report`, the JSON
// of the present report, `generation`, its number, and `points/GENERATION`, its points, as they come. Not thread-safe.
class PageServer {
 public:
  // Listens on the port, or on a free one if it is 0. INVALID_ARGUMENT naming the port and the system's reason if it
  // cannot.
  static absl::StatusOr<PageServer> Create(uint16_t port, std::string page,
                                           std::shared_ptr<const ReportShelf> shelf = nullptr);

  PageServer(PageServer&& other) noexcept;
  PageServer& operator=(PageServer&&) = delete;
  ~PageServer();

  // "http://127.0.0.1:PORT/PATH".
  std::string url() const;

  // Answers until a stop is requested, which it notices within a tenth of a second, or within ten while a browser takes
  // nothing of what it asked for. A connection that sends no whole request within ten seconds is closed.
  void Serve(const std::stop_token& stop);

 private:
  struct Answer {
    std::string bytes;                           // head, and body if it is short
    std::shared_ptr<const GrowingBytes> stream;  // the rest of the body; null if there is none
  };
  // Sends a long body, while others are served.
  struct Sending {
    std::shared_ptr<std::atomic<bool>> is_done;
    std::jthread thread;
  };

  PageServer(int descriptor, uint16_t port, std::string path, std::string page,
             std::shared_ptr<const ReportShelf> shelf)
      : descriptor_(descriptor),
        port_(port),
        path_(std::move(path)),
        page_(std::move(page)),
        shelf_(std::move(shelf)) {}
  Answer AnswerTo(const std::string& request) const;
  Answer AnswerBelow(const std::string& name, bool is_head) const;
  void Send(int descriptor, Answer answer);

  int descriptor_;  // -1 once moved from
  uint16_t port_;
  std::string path_;  // "/" and 32 hexadecimal digits
  std::string page_;
  std::shared_ptr<const ReportShelf> shelf_;
  std::list<Sending> sendings_;
};

}  // namespace curv
