// Tokens and certificates as they are used from the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "proto/access_list.h"
#include "server/curvature_server.h"
#include "tests/certificates.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class TokenTest : public ::testing::Test {
 protected:
  // A server that knows `tokens` only, over TLS.
  std::unique_ptr<curvd::CurvatureServer> Serve(const std::string& tokens) const {
    const curvd::PemPair certificate = certificates_.Issue("localhost");
    curvd::ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.metrics_listen = "";
    options.log = false;
    options.tls_cert = dir_.Write("server.crt", certificate.certificate);
    options.tls_key = dir_.Write("server.key", certificate.key);
    options.token_file = dir_.Write("tokens", tokens);
    return *curvd::CurvatureServer::Create(options);
  }

  const TempDir dir_;
  const curvd::TestCertificates certificates_;
};

TEST_F(TokenTest, FilesThatHoldNoCertificateOrKeyAreNamed) {
  const curvd::PemPair own = certificates_.Issue("alice"), other = certificates_.Issue("bob");
  const std::string ca = "--ca=" + dir_.Write("ca.crt", certificates_.authority());
  const std::string cert = "--cert=" + dir_.Write("own.crt", own.certificate);
  const auto message = [](const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"info", "--server=localhost:1"};
    words.insert(words.end(), flags.begin(), flags.end());
    const CurvRun run = RunCurv(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  for (const std::string& text :
       {std::string("no PEM"), own.key, certificates_.authority().substr(0, 100), std::string("-----BEGIN nothing")}) {
    const std::string file = dir_.Write("wrong", text);
    EXPECT_THAT(message({"--ca=" + file}), HasSubstr("--ca: " + file + ": no certificate can be read"));
    EXPECT_THAT(message({ca, "--cert=" + file, "--key=" + file}),
                HasSubstr("--cert: " + file + ": no certificate can be read"));
  }
  const std::string no_key = dir_.Write("no.key", own.certificate), other_key = dir_.Write("other.key", other.key);
  EXPECT_THAT(message({ca, cert, "--key=" + no_key}), HasSubstr("--key: " + no_key + ": no private key can be read"));
  EXPECT_THAT(message({ca, cert, "--key=" + other_key}),
              HasSubstr("--key: " + other_key + ": it is the private key of another certificate"));
}

TEST_F(TokenTest, ThereIsNoTokenWithoutItsLine) {
  const std::string file = dir_.File("bob.token");
  const CurvRun run = RunCurv({"token", "bob", "-o", file}, "", "/dev/full");
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.err, HasSubstr("no token was made"));
  EXPECT_FALSE(dir_.Has("bob.token"));
}

TEST_F(TokenTest, AServerTakesTheTokenWhoseLineWasPrinted) {
  const std::string file = dir_.File("alice.token");
  const CurvRun made = RunCurv({"token", "alice", "-o", file, "--max-points=1000"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, StartsWith("alice sha256:"));
  const auto server = Serve(made.out);
  const std::string ca = absl::StrCat("--ca=", dir_.Write("ca.crt", certificates_.authority()));
  const std::string address = absl::StrCat("--server=localhost:", server->port());
  const CurvRun info = RunCurv({"info", address, ca, "--token-file=" + file, "--json"});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, HasSubstr("\"max_points\":1000,"));
  EXPECT_THAT(RunCurv({"info", address, ca}).err, HasSubstr("TOKEN_MISSING"));
  EXPECT_EQ(RunCurv({"info", address, ca, "--health"}).out, "SERVING\n");
}

TEST_F(TokenTest, OnlyTheOwnerCanReadTheToken) {
  const std::string file = dir_.File("alice.token");
  const CurvRun made = RunCurv({"token", "alice", "-o", file});
  struct stat info = {};
  ASSERT_EQ(stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  const std::string token(absl::StripAsciiWhitespace(dir_.Read("alice.token")));
  EXPECT_GE(token.size(), 64u);
  EXPECT_THAT(made.out + made.err, Not(HasSubstr(token)));
}

TEST_F(TokenTest, NoFileIsOverwritten) {
  const std::string file = dir_.Write("alice.token", "an older one");
  const CurvRun run = RunCurv({"token", "alice", "-o", file});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.err, HasSubstr(file + ": the file exists, and may hold a token that is in use: name another file"));
  EXPECT_EQ(dir_.Read("alice.token"), "an older one");
}

TEST_F(TokenTest, TheServersFileIsNoToken) {
  const CurvRun made = RunCurv({"token", "alice", "-o", dir_.File("alice.token")});
  const std::string file = dir_.Write("tokens", made.out);
  const CurvRun run = RunCurv({"info", "--server=localhost:1", "--token-file=" + file});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--token-file: " + file + " holds hashes of tokens"));
}

TEST_F(TokenTest, NamesThatNoFileCanHoldAreRefused) {
  for (const char* name : {"two words", "#comment", "tab\tname"}) {
    EXPECT_EQ(RunCurv({"token", name, "-o", dir_.File("t")}).exit_code, 2) << name;
  }
  EXPECT_FALSE(dir_.Has("t"));
}

TEST_F(TokenTest, FlagsThatDoNotFitAreNamed) {
  const auto message = [](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"info", "--server=localhost:1"});
    const CurvRun run = RunCurv(flags);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  EXPECT_THAT(message({"--ca=" + dir_.File("none")}), HasSubstr("--ca: " + dir_.File("none")));
  EXPECT_THAT(message({"--token-file=" + dir_.Write("blank", " \n")}), HasSubstr("holds no token"));
  const std::string file = dir_.Write("long", std::string(5000, 'a'));
  EXPECT_THAT(message({"--token-file=" + file}), HasSubstr("--token-file: " + file + ": the token has 5000 bytes"));
  setenv("CURV_TOKEN", "two words", 1);
  EXPECT_THAT(message({}), HasSubstr("the variable CURV_TOKEN: the token must be printable ASCII without blanks"));
  unsetenv("CURV_TOKEN");
  EXPECT_THAT(message({"--cert=" + dir_.Write("crt", certificates_.authority())}), HasSubstr("private key"));
  EXPECT_THAT(message({"--server-name=other"}), HasSubstr("TLS"));
}

TEST_F(TokenTest, TheEnvironmentStandsInForFlags) {
  const auto server = Serve(absl::StrCat("alice ", curvd::FormatHash(curvd::HashToken("curvd_from_environment"))));
  setenv("CURV_TOKEN", "curvd_from_environment", 1);
  setenv("CURV_CA", dir_.Write("ca.crt", certificates_.authority()).c_str(), 1);
  const CurvRun info = RunCurv({"info", absl::StrCat("--server=localhost:", server->port())});
  const CurvRun remote = RunCurv({"info", "--server=curvd.example:50061", "--timeout=0.001"});
  unsetenv("CURV_CA");
  const CurvRun plain = RunCurv({"info", "--server=curvd.example:50061"});
  unsetenv("CURV_TOKEN");
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_NE(remote.exit_code, 2) << remote.err;
  EXPECT_EQ(plain.exit_code, 2);
  EXPECT_THAT(plain.err, HasSubstr("plain text"));
}

}  // namespace
}  // namespace curv
