#include "client/report/page_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"

namespace curv {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kMostConnections = 16;
constexpr size_t kMostSendings = 8;
constexpr size_t kMostRequestBytes = 16'384;
constexpr std::chrono::seconds kPatience(10);
constexpr int kPollMilliseconds = 100;
// The page says itself what it may do; nobody shall keep it, guess at its type or use it from elsewhere.
constexpr absl::string_view kHeaders =
    "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\nConnection: close\r\n";

absl::Status PortError(uint16_t port, int error_number) {
  return absl::InvalidArgumentError(
      absl::StrCat("--port: cannot listen on 127.0.0.1:", port, ": ", std::strerror(error_number)));
}

// A browser that is connected and has not sent a whole request so far.
struct Connection {
  int descriptor;
  Clock::time_point deadline;
  std::string request{};
};

// Sends all bytes unless the browser takes none for kPatience; returns whether it did.
bool SendAll(int descriptor, absl::string_view bytes) {
  const timeval patience{.tv_sec = kPatience.count(), .tv_usec = 0};
  setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  while (!bytes.empty()) {
    const ssize_t sent = send(descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

// Reads what is there. Returns false once the connection is of no more use.
bool Read(Connection& connection) {
  std::array<char, 4096> bytes;
  const ssize_t count = recv(connection.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  connection.request.append(bytes.data(), static_cast<size_t>(count));
  return count > 0 && connection.request.size() <= kMostRequestBytes;
}

bool IsWhole(const std::string& request) { return absl::StrContains(request, "\r\n\r\n"); }

// The value of the only field `host` of a request; empty if there is none or more than one.
absl::string_view HostOf(absl::string_view request) {
  absl::string_view host;
  size_t count = 0;
  for (absl::string_view line : absl::StrSplit(request, "\r\n")) {
    if (!absl::StartsWithIgnoreCase(line, "host:")) continue;
    host = absl::StripAsciiWhitespace(line.substr(5));
    ++count;
  }
  return count == 1 ? host : absl::string_view();
}

std::string Refusal(absl::string_view status) {
  return absl::StrCat("HTTP/1.1 ", status, "\r\n", kHeaders, "Content-Length: 0\r\n\r\n");
}

std::string Success(absl::string_view type, size_t length) {
  return absl::StrCat("HTTP/1.1 200 OK\r\nContent-Type: ", type, "\r\n", kHeaders, "Content-Length: ", length,
                      "\r\n\r\n");
}

}  // namespace

absl::StatusOr<PageServer> PageServer::Create(uint16_t port, std::string page,
                                              std::shared_ptr<const ReportShelf> shelf) {
  std::array<char, 16> secret;
  if (getrandom(secret.data(), secret.size(), 0) != static_cast<ssize_t>(secret.size())) return PortError(port, errno);
  const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return PortError(port, errno);
  PageServer server(descriptor, port,
                    absl::StrCat("/", absl::BytesToHexString(absl::string_view(secret.data(), secret.size()))),
                    std::move(page), std::move(shelf));
  const int reuse = 1;
  setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof(reuse));
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  if (bind(descriptor, reinterpret_cast<sockaddr*>(&address), length) != 0 || listen(descriptor, 16) != 0 ||
      getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    return PortError(port, errno);
  }
  server.port_ = ntohs(address.sin_port);
  return server;
}

PageServer::PageServer(PageServer&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      port_(other.port_),
      path_(std::move(other.path_)),
      page_(std::move(other.page_)),
      shelf_(std::move(other.shelf_)),
      sendings_(std::move(other.sendings_)) {}

PageServer::~PageServer() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string PageServer::url() const { return absl::StrCat("http://127.0.0.1:", port_, path_); }

PageServer::Answer PageServer::AnswerTo(const std::string& request) const {
  const std::vector<absl::string_view> words =
      absl::StrSplit(absl::string_view(request).substr(0, request.find("\r\n")), ' ');
  const absl::string_view host = HostOf(request);
  if (words.size() != 3 || !absl::StartsWith(words[2], "HTTP/1.")) return {Refusal("400 Bad Request"), nullptr};
  if (host != absl::StrCat("127.0.0.1:", port_) && host != absl::StrCat("localhost:", port_)) {
    return {Refusal("421 Misdirected Request"), nullptr};
  }
  absl::string_view below = words[1];
  if (!absl::ConsumePrefix(&below, path_)) return {Refusal("404 Not Found"), nullptr};
  if (words[0] != "GET" && words[0] != "HEAD") return {Refusal("405 Method Not Allowed"), nullptr};
  const bool is_head = words[0] == "HEAD";
  if (!below.empty()) return AnswerBelow(std::string(below), is_head);
  return {Success("text/html; charset=utf-8", page_.size()) + (is_head ? "" : page_), nullptr};
}

PageServer::Answer PageServer::AnswerBelow(const std::string& name, bool is_head) const {
  const std::shared_ptr<const ServedReport> report = shelf_ == nullptr ? nullptr : shelf_->Get();
  if (report == nullptr) return {Refusal("404 Not Found"), nullptr};
  const auto json = [&](const std::string& body) {
    return Answer{Success("application/json", body.size()) + (is_head ? "" : body), nullptr};
  };
  if (name == "/report") return json(report->report);
  if (name == "/generation") return json(absl::StrCat(report->generation));
  if (name != absl::StrCat("/points/", report->generation)) return {Refusal("404 Not Found"), nullptr};
  return {Success("application/octet-stream", report->points->total()), is_head ? nullptr : report->points};
}

void PageServer::Send(int descriptor, Answer answer) {
  if (answer.stream == nullptr || sendings_.size() >= kMostSendings) {
    SendAll(descriptor, answer.stream == nullptr ? answer.bytes : Refusal("503 Service Unavailable"));
    close(descriptor);
    return;
  }
  const auto is_done = std::make_shared<std::atomic<bool>>(false);
  sendings_.push_back(
      {is_done, std::jthread([descriptor, is_done, answer = std::move(answer)](const std::stop_token& stop) {
         bool is_sent = SendAll(descriptor, answer.bytes);
         for (size_t at = 0; is_sent;) {
           const std::string_view piece = answer.stream->Read(at, stop);
           if (piece.empty()) break;
           at += piece.size();
           is_sent = SendAll(descriptor, absl::string_view(piece.data(), piece.size()));
         }
         close(descriptor);
         *is_done = true;
       })});
}

void PageServer::Serve(const std::stop_token& stop) {
  std::vector<Connection> connections;
  while (!stop.stop_requested()) {
    sendings_.remove_if([](const Sending& sending) { return sending.is_done->load(); });
    std::vector<pollfd> polled = {{.fd = descriptor_, .events = POLLIN, .revents = 0}};
    for (const Connection& connection : connections) polled.push_back({connection.descriptor, POLLIN, 0});
    if (poll(polled.data(), polled.size(), kPollMilliseconds) < 0) continue;
    std::vector<Connection> waiting;
    for (size_t c = 0; c < connections.size(); ++c) {
      Connection& connection = connections[c];
      const bool is_open = polled[c + 1].revents == 0 || Read(connection);
      if (IsWhole(connection.request)) {
        Send(connection.descriptor, AnswerTo(connection.request));
        continue;
      }
      if (is_open && Clock::now() < connection.deadline) {
        waiting.push_back(std::move(connection));
        continue;
      }
      close(connection.descriptor);
    }
    connections = std::move(waiting);
    if (polled[0].revents == 0 || connections.size() >= kMostConnections) continue;
    const int accepted = accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC);
    if (accepted >= 0) connections.push_back({.descriptor = accepted, .deadline = Clock::now() + kPatience});
  }
  for (const Connection& connection : connections) close(connection.descriptor);
  sendings_.clear();  // asks each to stop, and waits for it
}

}  // namespace curv
