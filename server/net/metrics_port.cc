#include "server/net/metrics_port.h"

#include <CivetServer.h>
#include <arpa/inet.h>
#include <civetweb.h>
#include <netinet/in.h>
#include <prometheus/exposer.h>
#include <sys/socket.h>
#include <unistd.h>

#include <exception>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "server/host/ticker.h"

namespace curvd {

namespace {

// Connects to an IPv4 port of this machine and hangs up; does nothing if `listen` is another kind of address.
void Connect(const std::string& listen, int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  if (inet_pton(AF_INET, listen.substr(0, listen.rfind(':')).c_str(), &address.sin_addr) != 1) return;
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  (void)connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  close(fd);
}

// Answers what the exposer answers with 404, though /metrics is there: HEAD, and methods that have no meaning here.
// Returns the status code, or 0 where it leaves the request to the exposer.
int AnswerOtherMethods(mg_connection* connection) {
  const mg_request_info& request = *mg_get_request_info(connection);
  const std::string_view method = request.request_method;
  if (request.local_uri != std::string_view("/metrics") || method == "GET") return 0;
  if (method == "HEAD") {
    mg_printf(connection, "HTTP/1.1 200 OK\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n\r\n");
    return 200;
  }
  mg_printf(connection,
            "HTTP/1.1 405 Method Not Allowed\r\nAllow: GET, HEAD\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
  return 405;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsPort>> MetricsPort::Create(
    const std::string& listen, std::vector<std::shared_ptr<prometheus::Collectable>> collectables) {
  // Whoever does not finish a request holds a thread for a second. Others find a thread meanwhile, or wait their turn;
  // a thread is cheap, with a stack of 100 KiB.
  const std::vector<std::string> settings = {"listening_ports",    listen, "num_threads", "32",
                                             "request_timeout_ms", "1000"};
  CivetCallbacks callbacks;
  callbacks.begin_request = &AnswerOtherMethods;
  try {
    auto exposer = std::make_unique<prometheus::Exposer>(settings, &callbacks);
    for (const auto& collectable : collectables) exposer->RegisterCollectable(collectable);
    const std::vector<int> ports = exposer->GetListeningPorts();
    const int port = ports.empty() ? 0 : ports.front();
    return absl::WrapUnique(new MetricsPort(listen, std::move(collectables), std::move(exposer), port));
  } catch (const std::exception& error) {
    return absl::UnavailableError(absl::StrCat("cannot listen for metrics on ", listen,
                                               ": in use, not permitted, or no address of this machine"));
  }
}

MetricsPort::MetricsPort(std::string listen, std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
                         std::unique_ptr<prometheus::Exposer> exposer, int port)
    : listen_(std::move(listen)), collectables_(std::move(collectables)), exposer_(std::move(exposer)), port_(port) {}

// The exposer notices only after up to two seconds of silence that it shall stop: connections wake it earlier.
MetricsPort::~MetricsPort() {
  const Ticker wake(std::chrono::milliseconds(2), [this](Ticker::Clock::time_point) { Connect(listen_, port_); });
  exposer_.reset();
}

}  // namespace curvd
