// The C++ client against servers that ask who it is: what works, and what it says when it does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/crypto.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/connect_options.h"
#include "client/curvature_client.h"
#include "proto/access_list.h"
#include "server/access/tls_identity.h"
#include "server/curvature_server.h"
#include "tests/certificates.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kToken[] = "curvd_a_token";

class SecureClientTest : public ::testing::Test {
 protected:
  // A server with this certificate, which asks for a client certificate too if `mutual`, and for kToken.
  void Serve(const curvd::PemPair& certificate, bool mutual = false) {
    curvd::ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.metrics_listen = "";
    options.log = false;
    if (!certificate.key.empty()) {
      options.tls_cert = dir_.Write("server.crt", certificate.certificate);
      options.tls_key = dir_.Write("server.key", certificate.key);
    }
    if (mutual) options.tls_client_ca = dir_.Write("ca.crt", certificates_.authority());
    options.token_file =
        dir_.Write("tokens", absl::StrCat("alice ", curvd::FormatHash(curvd::HashToken(kToken)), "\n"));
    auto server = curvd::CurvatureServer::Create(options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  ConnectOptions Trusting() const {
    ConnectOptions options;
    options.tls = true;
    options.authorities = certificates_.authority();
    options.token = kToken;
    return options;
  }

  // What the server says about itself, as `options` reach it.
  absl::StatusOr<ServerInfo> Ask(ConnectOptions options) const {
    // By number: a name has two addresses, and what is told may be that nobody listens at the other.
    if (options.tls && options.server_name.empty()) options.server_name = "localhost";
    const auto client = CurvatureClient::Connect(absl::StrCat("127.0.0.1:", server_->port()), options);
    if (!client.ok()) return client.status();
    return (*client)->GetServerInfo(absl::Minutes(1));
  }

  std::string MessageOf(const ConnectOptions& options) const {
    const absl::Status status = Ask(options).status();
    EXPECT_FALSE(status.ok());
    EXPECT_THAT(status.ToString(), Not(HasSubstr(kToken)));
    return std::string(status.message());
  }

  const TempDir dir_;
  const curvd::TestCertificates certificates_;
  std::unique_ptr<curvd::CurvatureServer> server_;
};

TEST_F(SecureClientTest, ReachesAServerThatAsksForEverything) {
  Serve(certificates_.Issue("localhost"), /*mutual=*/true);
  ConnectOptions options = Trusting();
  const curvd::PemPair own = certificates_.Issue("alice");
  options.certificate = own.certificate;
  options.private_key = own.key;
  const absl::StatusOr<ServerInfo> info = Ask(options);
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->health, "SERVING");
  const auto client = *CurvatureClient::Connect(absl::StrCat("localhost:", server_->port()), options);
  const std::vector<float> empty;
  EXPECT_TRUE(client->Estimate(CloudView(empty, empty), {}).ok());
}

TEST_F(SecureClientTest, SaysThatTheServerAsksForACertificate) {
  Serve(certificates_.Issue("localhost"), /*mutual=*/true);
  EXPECT_THAT(MessageOf(Trusting()), HasSubstr("may ask for a client certificate (--cert, --key)"));
}

TEST_F(SecureClientTest, SaysThatTheServerSpeaksTls) {
  Serve(certificates_.Issue("localhost"));
  ConnectOptions options;
  options.token = kToken;
  EXPECT_THAT(MessageOf(options), HasSubstr("may speak TLS only (--tls)"));
}

TEST_F(SecureClientTest, SaysThatTheServerSpeaksPlainText) {
  Serve({});
  EXPECT_THAT(MessageOf(Trusting()), HasSubstr("the server speaks plain text on this port"));
}

TEST_F(SecureClientTest, SaysThatTheCertificateIsForAnotherName) {
  Serve(certificates_.Issue("curvd.example"));
  EXPECT_THAT(MessageOf(Trusting()), HasSubstr("not for the name that was asked for"));
  ConnectOptions options = Trusting();
  options.server_name = "curvd.example";
  EXPECT_TRUE(Ask(options).ok());
}

TEST_F(SecureClientTest, SaysThatTheCertificateHasExpired) {
  Serve(certificates_.Issue("localhost", -1));
  EXPECT_THAT(MessageOf(Trusting()), HasSubstr("the server's certificate has expired, or"));
}

TEST_F(SecureClientTest, SaysThatTheAuthorityIsNotTrusted) {
  Serve(certificates_.Issue("localhost"));
  ConnectOptions options = Trusting();
  options.authorities = curvd::TestCertificates().authority();
  EXPECT_THAT(MessageOf(options), HasSubstr("does not trust (--ca)"));
}

TEST_F(SecureClientTest, TokensAreNamedByTheirReason) {
  Serve(certificates_.Issue("localhost"));
  ConnectOptions options = Trusting();
  options.token = "curvd_another";
  EXPECT_EQ(ErrorReason(Ask(options).status()), "TOKEN_INVALID");
  options.token = "";
  EXPECT_EQ(ErrorReason(Ask(options).status()), "TOKEN_MISSING");
}

TEST_F(SecureClientTest, HealthNeedsNoToken) {
  Serve(certificates_.Issue("localhost"));
  ConnectOptions options = Trusting();
  options.token = "";
  const auto client = *CurvatureClient::Connect(absl::StrCat("localhost:", server_->port()), options);
  EXPECT_EQ(*client->GetHealth(absl::Minutes(1)), "SERVING");
}

TEST_F(SecureClientTest, ATokenGoesInPlainTextToThisMachineOnly) {
  Serve({});
  ConnectOptions options;
  options.token = kToken;
  EXPECT_TRUE(Ask(options).ok());
  for (const char* server : {"curvd.example:50061", "10.0.0.7:50061", "127.0.0.1:1,10.0.0.7:50061",
                             "127.evil.example:1", "dns:///localhost:1"}) {
    const absl::Status status = CurvatureClient::Connect(server, options).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << server;
    EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr("plain text"), Not(HasSubstr(kToken))));
  }
  options.send_token_in_plain_text = true;
  EXPECT_TRUE(CurvatureClient::Connect("10.0.0.7:50061", options).ok());
  options.send_token_in_plain_text = false;
  options.tls = true;
  EXPECT_TRUE(CurvatureClient::Connect("10.0.0.7:50061", options).ok());
}

TEST(ConnectOptionsTest, WhatDoesNotFitTogetherIsRefused) {
  constexpr char kPem[] = "-----BEGIN CERTIFICATE-----";
  const auto refused = [](const std::function<void(ConnectOptions&)>& change) {
    ConnectOptions options;
    change(options);
    const absl::Status status = CheckConnectOptions(options);
    EXPECT_TRUE(absl::IsInvalidArgument(status));
    if (!options.token.empty()) {
      EXPECT_THAT(std::string(status.message()), Not(HasSubstr(options.token)));
    }
  };
  refused([&](ConnectOptions& options) { options.authorities = kPem; });
  refused([&](ConnectOptions& options) { options.server_name = "curvd.example"; });
  refused([&](ConnectOptions& options) { options.tls = true, options.authorities = "no PEM"; });
  refused([&](ConnectOptions& options) { options.tls = true, options.certificate = kPem; });
  refused([&](ConnectOptions& options) { options.tls = true, options.private_key = kPem; });
  refused([](ConnectOptions& options) { options.token = "two words"; });
  refused([](ConnectOptions& options) { options.token = "line\nbreak"; });
  refused([](ConnectOptions& options) { options.token = std::string(5'000, 'x'); });
}

// Runs `first_use` in a process of its own, which then exits. Exits with 1 where OpenSSL is freed on the way.
void ExpectOpenSslIsKept(const std::function<void()>& first_use) {
  EXPECT_EXIT(
      {
        first_use();
        OPENSSL_init_crypto(0, nullptr);
        OPENSSL_atexit([] { _exit(1); });
        std::exit(0);
      },
      ::testing::ExitedWithCode(0), "");
}

TEST(OpenSslDeathTest, IsKeptAtExit) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  ExpectOpenSslIsKept([] {
    ConnectOptions options;
    options.tls = true;
    (void)CurvatureClient::Connect("localhost:1", options);
  });
  ExpectOpenSslIsKept([] { curvd::HashToken(kToken); });
  ExpectOpenSslIsKept([] { (void)curvd::MakeTlsIdentity("", "", ""); });
}

}  // namespace
}  // namespace curv
