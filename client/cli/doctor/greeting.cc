#include "client/cli/doctor/greeting.h"

#include <cerrno>

namespace curv {
namespace {

constexpr size_t kFrameHeaderBytes = 9;

}  // namespace

const std::string_view kHttp2Preface{"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33};

Greeting GreetingOf(std::string_view answer) {
  constexpr char kSettings = 4;
  constexpr char kGoAway = 7;
  if (answer.empty()) return Greeting::kClosed;
  if (answer.starts_with("HTTP/")) return Greeting::kHttp1;
  if (answer.starts_with("\x15\x03")) return Greeting::kTls;
  // The server's first frame is SETTINGS; one that has too many connections may say goodbye instead. Both are short.
  const bool is_frame =
      answer.size() >= kFrameHeaderBytes && answer[0] == 0 && (answer[3] == kSettings || answer[3] == kGoAway);
  return is_frame ? Greeting::kHttp2 : Greeting::kOther;
}

absl::StatusOr<Greeting> GreetInPlainText(const Address& address, absl::Duration timeout) {
  const absl::StatusOr<Socket> socket = Socket::Connect(address, timeout);
  if (!socket.ok()) return socket.status();
  if (!socket->Send(kHttp2Preface)) return Greeting::kClosed;
  errno = 0;
  const std::string answer = socket->Receive(kFrameHeaderBytes);
  if (answer.empty() && (errno == EAGAIN || errno == EWOULDBLOCK)) return Greeting::kSilence;
  return GreetingOf(answer);
}

}  // namespace curv
