#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "proto/access_list.h"

namespace curv {
namespace {

constexpr char kTokenExamples[] =
    "The token goes to FILE, which only you can read; what curvd needs goes to standard output:\n"
    "  curv token alice -o alice.token >> tokens          then: curvd --token-file=tokens\n"
    "  curv estimate scan.ply -o out.ply --server=curvd.example:50061 --tls --token-file=alice.token\n"
    "curvd keeps the hash alone, from which nobody can make the token. To revoke the token, delete its line.";

struct TokenFlags {
  std::string name;
  std::string output;
  uint64_t max_streams = 0;
  uint64_t max_points = 0;
};

// 256 random bits. The word before them lets scanners for leaked secrets know it.
std::string MakeToken() {
  std::array<char, 32> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return "";
  return absl::StrCat("curvd_", absl::BytesToHexString(absl::string_view(bytes.data(), bytes.size())));
}

// Writes the token to a new file that nobody else may read. Returns why it could not, or "".
std::string Save(const std::string& token, const std::string& path) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0 && errno == EEXIST) {
    return "the file exists, and may hold a token that is in use: name another file, or remove this one";
  }
  if (fd < 0) return std::strerror(errno);
  const std::string line = token + "\n";
  const bool written = write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int error = errno;
  if (close(fd) == 0 && written) return "";
  unlink(path.c_str());
  return std::strerror(error);
}

ExitCode Run(const TokenFlags& flags) {
  const std::string token = MakeToken();
  if (token.empty()) return Fail(ExitCode::kFailed, "the system gives no random bytes");
  std::string line = absl::StrCat(flags.name, " ", curvd::FormatHash(curvd::HashToken(token)));
  if (flags.max_streams > 0) absl::StrAppend(&line, " max-streams=", flags.max_streams);
  if (flags.max_points > 0) absl::StrAppend(&line, " max-points=", flags.max_points);
  const auto entries = curvd::ParseTokenFile(line);
  if (!entries.ok() || entries->size() != 1 || entries->front().name != flags.name) {
    return Fail(ExitCode::kUsage, absl::StrCat("\"", flags.name, "\" must be at most 128 printable ASCII characters ",
                                               "without blanks and quotes, and not begin with #"));
  }
  if (const std::string failure = Save(token, flags.output); !failure.empty()) {
    return Fail(ExitCode::kOutput, absl::StrCat(flags.output, ": ", failure));
  }
  // Without its line, a token is of no use.
  if (std::printf("%s\n", line.c_str()) < 0 || std::fflush(stdout) != 0) {
    const std::string failure = std::strerror(errno);
    unlink(flags.output.c_str());
    return Fail(ExitCode::kOutput, absl::StrCat("standard output: ", failure, "; no token was made"));
  }
  return ExitCode::kOk;
}

}  // namespace

void AddToken(CLI::App& app, Action& action) {
  auto flags = std::make_shared<TokenFlags>();
  CLI::App* command = app.add_subcommand("token", "Make a bearer token, and the line that lets it into a curvd");
  command->footer(absl::StrCat(kTokenExamples, "\n", kExitCodesHelp));
  command->add_option("name", flags->name, "whom the token is for, as logs will call it")
      ->required()
      ->option_text("NAME");
  command->add_option("-o,--output", flags->output, "where the token goes; must not exist")
      ->required()
      ->option_text("FILE");
  command->add_option("--max-streams", flags->max_streams, "calls that it may have open [as the server allows any]")
      ->check(Whole(1, 100'000))
      ->option_text("COUNT");
  command->add_option("--max-points", flags->max_points, "points in one of its clouds [as the server allows any]")
      ->check(Whole(1, (uint64_t{1} << 31) - 1))
      ->option_text("COUNT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
