// Names who makes a call, as far as the server knows.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "proto/access_list.h"

namespace curvd {

struct Caller {
  // What logs call it, and whose limits it shares: the name of its token, else of its certificate, else its address.
  std::string name;
  uint32_t max_streams = 0;  // calls that it may have open; 0: as many as any peer
  uint64_t max_points = 0;   // points in one of its clouds; 0: as many as any call
  // What let it in: the hash of its token, the name of its certificate; none and empty where anybody may call.
  std::optional<Sha256> token_hash;
  std::string certificate_name;
};

// Stands for the caller wherever callers take turns: at the workers and for memory. All calls under one name share it.
// Never 0. Two names have the same key once in 2^64; their callers then share their turns, which harms nobody else.
inline uint64_t TurnKey(const Caller& caller) {
  const uint64_t key = std::hash<std::string>()(caller.name);
  return key == 0 ? 1 : key;
}

}  // namespace curvd
