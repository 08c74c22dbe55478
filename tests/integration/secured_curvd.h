// A curvd process that asks who calls, and a client whom it lets in.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/certificates.h"
#include "tests/client/temp_dir.h"
#include "tests/integration/process.h"
#include "tests/integration/test_call.h"

namespace curvd {

inline constexpr char kFriendsToken[] = "curvd_friends_token";

// Asks for TLS, a client certificate with the name "friend", and the friend's token. Its files are those in dir().
class SecuredCurvd {
 public:
  explicit SecuredCurvd(const std::vector<std::string>& more_flags = {});

  Process& process() { return *process_; }
  const curv::TempDir& dir() const { return dir_; }
  const TestCertificates& certificates() const { return certificates_; }
  int port() const { return PortIn("listen"); }
  int health_port() const { return PortIn("health_listen"); }
  int metrics_port() const { return PortIn("metrics_listen"); }
  std::string address() const { return "localhost:" + std::to_string(port()); }

  // Token files with a line for the friend and what `others` says.
  void WriteTokens(const std::string& others = "") const;

  // A channel with this certificate; none, if it is empty.
  std::shared_ptr<grpc::Channel> NewChannel(const PemPair& certificate) const;
  std::shared_ptr<grpc::Channel> FriendsChannel() const { return NewChannel(friends_); }
  // Whether the friend is served.
  ::testing::AssertionResult ServesTheFriend() const;

  // curvd_strangers_total.
  double Strangers(const std::string& reason) const;
  // Waits until at least `count` strangers were counted; fails the test after a minute.
  void WaitForStrangers(const std::string& reason, double count = 1) const;

 private:
  int PortIn(const std::string& key) const;

  const curv::TempDir dir_;
  const TestCertificates certificates_;
  const PemPair friends_ = certificates_.Issue("friend");
  std::unique_ptr<Process> process_;
  std::string serving_line_;
};

// A call of a thousand points over `channel`, with this token unless it is empty, and `filler` bytes of other metadata.
CallResult CallWith(const std::shared_ptr<grpc::Channel>& channel, const std::string& token, size_t filler = 0);

}  // namespace curvd
