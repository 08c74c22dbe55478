// Serves one page to browsers of this machine.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace curv {

// Answers HTTP/1.1 (RFC 9110, RFC 9112) on 127.0.0.1: GET and HEAD of one path, which holds 128 random bits, so that no
// other user of the machine and no other page in the browser can ask for it. Requests with another host in them than
// this machine's are refused, whatever name leads here. Not thread-safe.
class PageServer {
 public:
  // Listens on the port, or on a free one if it is 0. INVALID_ARGUMENT naming the port and the system's reason if it
  // cannot.
  static absl::StatusOr<PageServer> Create(uint16_t port, std::string page);

  PageServer(PageServer&& other) noexcept;
  PageServer& operator=(PageServer&&) = delete;
  ~PageServer();

  // "http://127.0.0.1:PORT/PATH".
  std::string url() const;

  // Answers until a stop is requested, which it notices within a tenth of a second, or within ten while a browser takes
  // nothing of the page. A connection that sends no whole request within ten seconds is closed.
  void Serve(const std::stop_token& stop);

 private:
  PageServer(int descriptor, uint16_t port, std::string path, std::string page)
      : descriptor_(descriptor), port_(port), path_(std::move(path)), page_(std::move(page)) {}
  std::string Answer(const std::string& request) const;

  int descriptor_;  // -1 once moved from
  uint16_t port_;
  std::string path_;  // "/" and 32 hexadecimal digits
  std::string page_;
};

}  // namespace curv
