#include "server/flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace curvd {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

absl::StatusOr<CommandLine> Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "curvd");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data(), "curvd 7.8.9 (of a test)");
}

TEST(ParseCommandLineTest, WithoutFlagsGivesTheDefaults) {
  const auto line = Parse({});
  ASSERT_TRUE(line.ok()) << line.status();
  EXPECT_EQ(line->options.listen, "127.0.0.1:50061");
  EXPECT_EQ(line->options.metrics_listen, "127.0.0.1:9461");
  EXPECT_EQ(line->options.max_chunk_bytes, 4u << 20);
  EXPECT_TRUE(line->answer.empty());
}

TEST(ParseCommandLineTest, TakesEveryFlag) {
  const auto line = Parse({"--listen=0.0.0.0:1",
                           "--insecure",
                           "--health-listen=0.0.0.0:2",
                           "--metrics-listen=none",
                           "--threads=3",
                           "--max-points=7",
                           "--max-chunk-bytes=1MiB",
                           "--max-neighbor-count=99",
                           "--memory-limit=2GiB",
                           "--max-streams=5",
                           "--max-waiting=6",
                           "--drain-timeout=1m30s",
                           "--stall-timeout=250ms",
                           "--log=false",
                           "--tls-cert=a.crt",
                           "--tls-key=a.key",
                           "--tls-client-ca=ca.crt",
                           "--tls-client-names=names",
                           "--token-file=tokens",
                           "--max-streams-per-peer=4",
                           "--max-connections=8",
                           "--max-connections-per-peer=9",
                           "--max-header-bytes=4KiB",
                           "--idle-timeout=2m",
                           "--handshake-timeout=3s"});
  ASSERT_TRUE(line.ok()) << line.status();
  const ServerOptions& options = line->options;
  EXPECT_EQ(options.listen, "0.0.0.0:1");
  EXPECT_EQ(options.metrics_listen, "");
  EXPECT_EQ(options.threads, 3);
  EXPECT_EQ(options.max_points, 7u);
  EXPECT_EQ(options.max_chunk_bytes, 1u << 20);
  EXPECT_EQ(options.max_neighbor_count, 99u);
  EXPECT_EQ(options.memory_limit_bytes, uint64_t{2} << 30);
  EXPECT_EQ(options.max_streams, 5u);
  EXPECT_EQ(options.max_waiting, 6u);
  EXPECT_EQ(options.drain_timeout, absl::Seconds(90));
  EXPECT_EQ(options.stall_timeout, absl::Milliseconds(250));
  EXPECT_FALSE(options.log);
  EXPECT_TRUE(options.insecure);
  EXPECT_EQ(options.health_listen, "0.0.0.0:2");
  EXPECT_EQ(options.tls_cert, "a.crt");
  EXPECT_EQ(options.tls_key, "a.key");
  EXPECT_EQ(options.tls_client_ca, "ca.crt");
  EXPECT_EQ(options.tls_client_names, "names");
  EXPECT_EQ(options.token_file, "tokens");
  EXPECT_EQ(options.max_streams_per_peer, 4u);
  EXPECT_EQ(options.max_connections, 8u);
  EXPECT_EQ(options.max_connections_per_peer, 9u);
  EXPECT_EQ(options.max_header_bytes, 4096u);
  EXPECT_EQ(options.idle_timeout, absl::Minutes(2));
  EXPECT_EQ(options.handshake_timeout, absl::Seconds(3));
}

TEST(ParseCommandLineTest, NumbersThatAreNoneAreNamedAsTheyWereGiven) {
  for (const char* flag : {"--max-points=-1", "--memory-limit=-1", "--max-chunk-bytes=-4KiB", "--threads=-1",
                           "--threads=abc", "--max-streams=+1"}) {
    const auto line = Parse({flag});
    ASSERT_FALSE(line.ok()) << flag;
    const std::string given = std::string(flag).substr(std::string(flag).find('=') + 1);
    EXPECT_NE(line.status().message().find("\"" + given + "\" must be a whole number of 0 or more"), std::string::npos)
        << line.status();
  }
}

TEST(ParseCommandLineTest, AddressesWithoutAPortAreRefused) {
  const auto line = Parse({"--metrics-listen=foo"});
  ASSERT_FALSE(line.ok());
  EXPECT_NE(line.status().message().find("--metrics-listen is foo; it must be HOST:PORT"), std::string::npos);
}

TEST(ParseCommandLineTest, FallsBackToTheEnvironment) {
  setenv("CURVD_INSECURE", "true", 1);
  setenv("CURVD_MAX_STREAMS", "17", 1);
  setenv("CURVD_DRAIN_TIMEOUT", "5s", 1);
  setenv("CURVD_MEMORY_LIMIT", "64MiB", 1);
  const auto from_environment = Parse({});
  const auto from_flag = Parse({"--max-streams=18"});
  unsetenv("CURVD_INSECURE");
  unsetenv("CURVD_MAX_STREAMS");
  unsetenv("CURVD_DRAIN_TIMEOUT");
  unsetenv("CURVD_MEMORY_LIMIT");
  ASSERT_TRUE(from_environment.ok()) << from_environment.status();
  EXPECT_TRUE(from_environment->options.insecure);
  EXPECT_EQ(from_environment->options.max_streams, 17u);
  EXPECT_EQ(from_environment->options.drain_timeout, absl::Seconds(5));
  EXPECT_EQ(from_environment->options.memory_limit_bytes, 64u << 20);
  ASSERT_TRUE(from_flag.ok());
  EXPECT_EQ(from_flag->options.max_streams, 18u);
}

TEST(ParseCommandLineTest, AnEmptyFileOfAccessIsAnErrorAndNotNoFile) {
  for (const char* flag : {"--tls-cert", "--tls-key", "--tls-client-ca", "--tls-client-names", "--token-file"}) {
    std::string variable = absl::StrCat("CURVD_", absl::AsciiStrToUpper(absl::StrReplaceAll(flag + 2, {{"-", "_"}})));
    setenv(variable.c_str(), "", 1);
    const auto from_environment = Parse({});
    const auto from_flag = Parse({absl::StrContains(flag, "token") ? "--token-file=tokens" : "--threads=1"});
    unsetenv(variable.c_str());
    EXPECT_EQ(from_environment.status().code(), absl::StatusCode::kInvalidArgument) << variable;
    EXPECT_THAT(std::string(from_environment.status().message()), AllOf(HasSubstr(variable), HasSubstr("a file")));
    // The command line wins.
    EXPECT_EQ(from_flag.ok(), absl::StrContains(flag, "token")) << from_flag.status();
    const auto empty_flag = Parse({flag, ""});
    EXPECT_EQ(empty_flag.status().code(), absl::StatusCode::kInvalidArgument) << flag;
    EXPECT_THAT(std::string(empty_flag.status().message()), HasSubstr(flag));
    EXPECT_FALSE(Parse({absl::StrCat(flag, "=").c_str()}).ok()) << flag;
  }
}

TEST(ParseCommandLineTest, HelpNamesEveryFlagItsVariableAndItsDefault) {
  const auto line = Parse({"--help"});
  ASSERT_TRUE(line.ok());
  for (const char* text : {"--listen",
                           "CURVD_LISTEN",
                           "127.0.0.1:50061",
                           "--metrics-listen",
                           "--threads",
                           "--max-points",
                           "--max-chunk-bytes",
                           "--max-neighbor-count",
                           "--memory-limit",
                           "CURVD_MEMORY_LIMIT",
                           "--max-streams",
                           "--max-waiting",
                           "--tls-cert",
                           "--tls-key",
                           "--tls-client-ca",
                           "--tls-client-names",
                           "--token-file",
                           "--insecure",
                           "CURVD_INSECURE",
                           "--health-listen",
                           "--max-connections",
                           "--drain-timeout",
                           "30s",
                           "--stall-timeout",
                           "--log",
                           "SIGTERM",
                           "curv estimate"}) {
    EXPECT_THAT(line->answer, HasSubstr(text));
  }
}

TEST(ParseCommandLineTest, VersionIsTheLineOfTheProgram) {
  const auto line = Parse({"--version"});
  ASSERT_TRUE(line.ok());
  EXPECT_EQ(line->answer, "curvd 7.8.9 (of a test)\n");
}

TEST(ParseCommandLineTest, NamesTheFlagThatItCannotUnderstand) {
  for (const auto& [flag, name] :
       std::vector<std::pair<const char*, const char*>>{{"--threads=two", "--threads"},
                                                        {"--drain-timeout=soon", "--drain-timeout"},
                                                        {"--memory-limit=lots", "--memory-limit"},
                                                        {"--no-such-flag=1", "--no-such-flag"},
                                                        {"--threads=-1", "--threads"},
                                                        {"--max-streams=0", "--max-streams"},
                                                        {"--max-streams=0100", "0100 must be a decimal number"},
                                                        {"--threads=0x2", "0x2 must be a decimal number"},
                                                        {"--memory-limit=0100", "0100 must be a decimal number"},
                                                        {"--memory-limit=8qb", "\"8qb\" must be a whole number"},
                                                        {"--max-points=1e9", "\"1e9\" must be a whole number"},
                                                        {"--threads=99999999999", "at most 2147483647"},
                                                        {"--max-points=", "--max-points: its value is missing"},
                                                        {"--memory-limt=8GiB", "did you mean --memory-limit?"},
                                                        {"--log=maybe", "--log: \"maybe\" must be true or false"},
                                                        {"--insecure=maybe", "--insecure: \"maybe\" must be"},
                                                        {"--insecure=4MiB", "--insecure: \"4MiB\" must be"},
                                                        {"--insecure=-1", "--insecure: \"-1\" must be"},
                                                        {"--log=18446744073709551615", "must be true or false"},
                                                        {"--max-header-bytes=5GiB", "at most 4294967295"}}) {
    const auto line = Parse({flag});
    EXPECT_EQ(line.status().code(), absl::StatusCode::kInvalidArgument) << flag;
    EXPECT_THAT(std::string(line.status().message()), HasSubstr(name));
  }
}

TEST(ParseCommandLineTest, WarnsOfVariablesThatNoFlagReads) {
  // As Kubernetes sets them for a service with the name curvd.
  const std::vector<const char*> known = {"CURVD_SERVICE_HOST", "CURVD_PORT_50061_TCP_ADDR", "CURVD_PORT"};
  for (const char* name : known) setenv(name, "x", 1);
  setenv("CURVD_MAX_STREAM", "5", 1);
  setenv("CURVD_NOTHING_LIKE_A_FLAG_OF_THE_SERVER", "5", 1);
  const auto line = Parse({});
  for (const char* name : known) unsetenv(name);
  unsetenv("CURVD_MAX_STREAM");
  unsetenv("CURVD_NOTHING_LIKE_A_FLAG_OF_THE_SERVER");
  ASSERT_TRUE(line.ok()) << line.status();
  ASSERT_EQ(line->warnings.size(), 2u);
  EXPECT_EQ(line->warnings[0],
            "no flag reads the environment variable CURVD_MAX_STREAM; did you mean CURVD_MAX_STREAMS?");
  EXPECT_EQ(line->warnings[1], "no flag reads the environment variable CURVD_NOTHING_LIKE_A_FLAG_OF_THE_SERVER");
  EXPECT_EQ(Parse({})->warnings.size(), 0u);
}

}  // namespace
}  // namespace curvd
