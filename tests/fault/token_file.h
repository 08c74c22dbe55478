// Callers of a server under test, who share nothing between them.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"

namespace curvd {

// The token of the caller NAME is "token-of-NAME".
inline constexpr char kTokenLines[] =
    "alice sha256:19c28a50b1a09097592e7ceddb7e0771ff4d469747541a7536579eef857e05ce\n"
    "bob sha256:800480042268218663feef3ea54d81ed3f976c98c38d5fd7afbe22810ec16334\n"
    "carol sha256:7efa3d541f0c00bd394d267ad3e2b99c0870ce0bd7dcadb9f89a82aa8de48941\n";

inline std::string BearerOf(const std::string& caller) { return "Bearer token-of-" + caller; }

// A directory with the file of tokens, removed at the end.
class TokenFile {
 public:
  TokenFile() : directory_(std::filesystem::temp_directory_path() / absl::StrCat("fault-callers-", getpid())) {
    std::filesystem::create_directory(directory_);
    std::ofstream(path()) << kTokenLines;
  }
  ~TokenFile() { std::filesystem::remove_all(directory_); }
  TokenFile(const TokenFile&) = delete;
  TokenFile& operator=(const TokenFile&) = delete;

  std::string path() const { return directory_ / "tokens"; }

 private:
  const std::filesystem::path directory_;
};

}  // namespace curvd
