#include "server/flags.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <limits>
#include <type_traits>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "proto/nearest_word.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

constexpr char kDescription[] =
    "curvd estimates the curvature of point clouds, and their normals, that clients stream to it over gRPC.\n"
    "It serves curvature.v1.CurvatureService, health and reflection on --listen, and Prometheus metrics on\n"
    "--metrics-listen. SIGTERM or SIGINT drains: no new calls, accepted ones finish; a second signal ends at once.";

constexpr char kFooter[] =
    "Every flag may be given as an environment variable: --max-streams is CURVD_MAX_STREAMS. The command line wins.\n"
    "\nTry it:\n"
    "  curvd --listen=127.0.0.1:50061 &\n"
    "  curv generate torus --points=100000 -o torus.ply\n"
    "  curv estimate torus.ply -o out.ply --server=127.0.0.1:50061\n"
    "  curl http://127.0.0.1:9461/metrics\n"
    "\nExit codes: 0 drained after SIGTERM or SIGINT; 1 cannot serve: an address is in use or not permitted,\n"
    "or what a file of certificates, tokens or names holds is wrong; 2 wrong flags, or a file that they name\n"
    "cannot be read; 3 a second signal ended the drain.\n";

// An empty value cannot be told from a missing one on a command line.
constexpr char kNoAddress[] = "none";

// "--max-streams" as CURVD_MAX_STREAMS.
std::string EnvironmentName(const std::string& flag) {
  std::string name = "CURVD_";
  for (const char c : flag.substr(2)) name += c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return name;
}

// CLI11 reads 0100 as 64, by the rules of C, and -1 as the largest number there is.
std::string CheckDecimal(const std::string& text) {
  if (text.size() > 1 && text[0] == '0') return absl::StrCat(text, " must be a decimal number without zeros before it");
  const bool is_whole =
      !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  return is_whole ? "" : absl::StrCat("\"", text, "\" must be a whole number of 0 or more, written in digits");
}

template <typename Value>
std::string CheckWhole(const std::string& text) {
  Value value;
  if (std::string fault = CheckDecimal(text); !fault.empty()) return fault;
  return absl::SimpleAtoi(text, &value)
             ? ""
             : absl::StrCat("\"", text, "\" must be a whole number of at most ", std::numeric_limits<Value>::max());
}

// CLI11 takes 1.5 and 4MiB for true, and aborts the program at numbers of 20 digits.
std::string CheckBool(const std::string& text) {
  for (const char* word : {"true", "false", "yes", "no", "on", "off", "1", "0"}) {
    if (absl::EqualsIgnoreCase(text, word)) return "";
  }
  return absl::StrCat("\"", text, "\" must be true or false");
}

template <typename Value>
CLI::Option* AddFlag(CLI::App& app, const char* flag, Value& value, const std::string& help) {
  CLI::Option* option = app.add_option(flag, value, help)->envname(EnvironmentName(flag))->capture_default_str();
  if constexpr (std::is_same_v<Value, bool>) {
    option->check(CheckBool, "");
  } else if constexpr (std::is_integral_v<Value>) {
    option->check(CheckWhole<Value>, "");
  }
  return option;
}

void AddDuration(CLI::App& app, const char* flag, absl::Duration& value, const std::string& help) {
  app.add_option_function<std::string>(
         flag,
         [flag, &value](const std::string& text) {
           if (!absl::ParseDuration(text, &value)) {
             throw CLI::ValidationError(flag, absl::StrCat(text, " is no duration such as 30s or 1m30s"));
           }
         },
         help)
      ->envname(EnvironmentName(flag))
      ->default_str(absl::FormatDuration(value))
      ->type_name("DURATION");
}

template <typename Value>
void AddBytes(CLI::App& app, const char* flag, Value& value, const std::string& help) {
  CLI::AsSizeValue with_unit(false);
  with_unit.description("");
  // A transformation comes before all checks.
  const CLI::Validator checked(
      [with_unit](std::string& text) {
        try {
          const size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
          std::string bytes = text;
          if (digits > 1 && text[0] == '0') return CheckDecimal(text);
          if (digits > 0 && with_unit(bytes).empty()) {
            text = bytes;
            return std::string();
          }
        } catch (const CLI::ValidationError&) {  // of a unit that there is not
        }
        return absl::StrCat("\"", text, "\" must be a whole number of 0 or more, of bytes or with a unit as in 8GiB");
      },
      "");
  AddFlag(app, flag, value, help)->transform(checked)->type_name("BYTES");
}

// The flags of the files that say who may call, and their variables. An empty value must not mean that anybody may.
constexpr const char* kAccessFlags[] = {"--tls-cert", "--tls-key", "--tls-client-ca", "--tls-client-names",
                                        "--token-file"};

absl::Status CheckAccessFlags(CLI::App& app) {
  for (const char* flag : kAccessFlags) {
    const CLI::Option& option = *app.get_option(flag);
    const std::string variable = EnvironmentName(flag);
    // CLI11 leaves an empty variable out.
    const bool is_empty_variable = option.count() == 0 && std::getenv(variable.c_str()) != nullptr;
    const bool is_empty_flag = option.count() > 0 && option.as<std::string>().empty();
    if (!is_empty_variable && !is_empty_flag) continue;
    return MakeError(
        absl::StatusCode::kInvalidArgument,
        {kReasonInvalidOption, is_empty_flag ? flag : variable, "\"\"", "the path of a file, or not given", {}});
  }
  return absl::OkStatus();
}

void AddAddresses(CLI::App& app, ServerOptions& options) {
  AddFlag(app, "--listen", options.listen, "Where calls are taken; port 0 picks a free one. Also unix:PATH")
      ->type_name("HOST:PORT");
  app.add_flag("--insecure", options.insecure, "Take plain text from other machines as well: encrypt in front of curvd")
      ->envname(EnvironmentName("--insecure"))
      ->check(CheckBool, "");
  AddFlag(app, "--health-listen", options.health_listen,
          "Where probes ask for health alone, in plain text and without a token: as --listen")
      ->type_name("HOST:PORT");
  AddFlag(app, "--metrics-listen", options.metrics_listen,
          "Where Prometheus scrapes /metrics, over IPv4; port 0 picks a free one, \"none\" for no metrics")
      ->type_name("HOST:PORT");
}

void AddAccess(CLI::App& app, ServerOptions& options) {
  AddFlag(app, "--tls-cert", options.tls_cert, "Certificate chain of the server, PEM; read again when it changes")
      ->type_name("FILE");
  AddFlag(app, "--tls-key", options.tls_key, "Its private key, PEM without a passphrase")->type_name("FILE");
  AddFlag(app, "--tls-client-ca", options.tls_client_ca,
          "Authorities, PEM: clients must show a certificate of one of them")
      ->type_name("FILE");
  AddFlag(app, "--tls-client-names", options.tls_client_names,
          "Names, one a line, of which a client's certificate must have one; read again when it changes")
      ->type_name("FILE");
  AddFlag(app, "--token-file", options.token_file,
          "Hashes of tokens, as `curv token` prints them, of which a call must carry one; read again when it changes")
      ->type_name("FILE");
}

void AddLimits(CLI::App& app, ServerOptions& options) {
  AddFlag(app, "--threads", options.threads,
          "Worker threads that all calls share; 0: one for each core that the container or machine may use")
      ->type_name("N");
  AddFlag(app, "--max-points", options.max_points, "Points in one cloud")->type_name("N");
  AddBytes(app, "--max-chunk-bytes", options.max_chunk_bytes, "Bytes of one chunk's arrays; units as in 4MiB");
  AddFlag(app, "--max-neighbor-count", options.max_neighbor_count, "Points in one neighborhood")->type_name("N");
  AddBytes(app, "--memory-limit", options.memory_limit_bytes,
           "Bytes that all calls together may hold, such as 8GiB; 0: 80 % of what the container or machine has");
  AddFlag(app, "--max-streams", options.max_streams, "Calls open at a time; further ones are refused")->type_name("N");
  AddFlag(app, "--max-streams-per-peer", options.max_streams_per_peer,
          "Calls that one caller (token, certificate, or else address) may have open")
      ->type_name("N");
  AddFlag(app, "--max-connections", options.max_connections, "Connections open at a time; further ones are closed")
      ->type_name("N");
  AddFlag(app, "--max-connections-per-peer", options.max_connections_per_peer, "Connections from one address")
      ->type_name("N");
  AddBytes(app, "--max-header-bytes", options.max_header_bytes, "Bytes of one call's metadata; units as in 16KiB");
  AddDuration(app, "--idle-timeout", options.idle_timeout, "How long a connection may be open without a call");
  AddDuration(app, "--handshake-timeout", options.handshake_timeout, "How long a new connection's handshake may take");
  AddFlag(app, "--max-waiting", options.max_waiting, "Calls that wait for memory at a time; further ones are refused")
      ->type_name("N");
  AddDuration(app, "--drain-timeout", options.drain_timeout,
              "How long accepted calls may take to finish after SIGTERM");
  AddDuration(app, "--stall-timeout", options.stall_timeout,
              "How long a call may send no points or take no results; while others wait for memory, also the time over "
              "which it must keep up 16 KiB a second");
  AddFlag(app, "--log", options.log, "One JSON line on stderr for each call")->type_name("BOOL");
}

std::vector<std::string> FlagNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// What the parser says, in words for people where its own are none.
std::string ParserText(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> unexpected = app.remaining();
  if (!unexpected.empty()) {
    return absl::StrCat("this argument was not expected: ", unexpected.front(),
                        DidYouMean(unexpected.front().substr(0, unexpected.front().find('=')), FlagNames(app)));
  }
  // "--max-points: 1 required N missing"
  const std::string text = error.what();
  const size_t required = text.find(": 1 required ");
  return required != std::string::npos && absl::EndsWith(text, " missing")
             ? absl::StrCat(text.substr(0, required), ": its value is missing or empty")
             : text;
}

// Whether Kubernetes, or a link between containers, sets such a variable for a service with the name curvd.
bool IsOfAService(absl::string_view variable) {
  return variable == "CURVD_PORT" || absl::StartsWith(variable, "CURVD_PORT_") ||
         absl::StartsWith(variable, "CURVD_SERVICE_");
}

// A warning for each variable that may be a mistyped one of a flag.
std::vector<std::string> UnknownVariables(const CLI::App& app) {
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_envname().empty()) known.push_back(option->get_envname());
  }
  std::vector<std::string> warnings;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string text = *entry, name = text.substr(0, text.find('='));
    if (!absl::StartsWith(name, "CURVD_") || IsOfAService(name)) continue;
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    warnings.push_back(absl::StrCat("no flag reads the environment variable ", name, DidYouMean(name, known)));
  }
  std::sort(warnings.begin(), warnings.end());
  return warnings;
}

}  // namespace

absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv, const std::string& version_line) {
  CommandLine line;
  CLI::App app(kDescription, "curvd");
  app.footer(kFooter);
  app.set_version_flag("--version", version_line, "Print version and commit, and exit");
  app.get_formatter()->column_width(32);
  AddAddresses(app, line.options);
  AddAccess(app, line.options);
  AddLimits(app, line.options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    line.answer = app.help();
    return line;
  } catch (const CLI::CallForVersion& version) {
    line.answer = absl::StrCat(version.what(), "\n");
    return line;
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(absl::StrCat(ParserText(app, error), " (curvd --help lists all flags)"));
  }
  if (absl::Status status = CheckAccessFlags(app); !status.ok()) return status;
  line.warnings = UnknownVariables(app);
  if (line.options.metrics_listen == kNoAddress) line.options.metrics_listen.clear();
  if (absl::Status status = line.options.Validate(); !status.ok()) return status;
  return line;
}

}  // namespace curvd
