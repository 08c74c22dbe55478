// Holds what an operator may set: plain values with defaults, checked by Validate.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/net/keepalive.h"

namespace curvd {

struct ServerOptions {
  // Where calls are taken: HOST:PORT (port 0 picks a free one), "unix:PATH", or "" for in-process calls only.
  std::string listen = "127.0.0.1:50061";  // DEFAULT: loopback
  // Lets `listen` be reachable from other machines without TLS.
  bool insecure = false;
  // Where health alone is told, without TLS or token, for probes: as `listen`, or "" for nowhere.
  std::string health_listen;
  // Where Prometheus scrapes /metrics: HOST:PORT (port 0 picks a free one), or "" for no metrics port.
  std::string metrics_listen = "127.0.0.1:9461";  // DEFAULT: loopback

  // PEM files: the server's certificate chain and its key. Both or none; "": plain text.
  std::string tls_cert;
  std::string tls_key;
  // PEM file: authorities of client certificates; "": clients need none.
  std::string tls_client_ca;
  // File of names (proto/access_list.h) of which a client certificate must have one; "": any name is let in.
  std::string tls_client_names;
  // File of tokens (proto/access_list.h) of which a call must carry one; "": calls need none.
  std::string token_file;

  // Worker threads that all calls share; 0: one for each core that this process may use, and no more than the quotas
  // of its control groups are worth (server/host/processor_limit.h).
  int threads = 0;

  // Points in one cloud. In [1, 2^31).
  uint64_t max_points = 200'000'000;
  // Bytes of one PointChunk's arrays together. In [1 KiB, 256 MiB].
  uint64_t max_chunk_bytes = 4 << 20;
  // Points in one neighborhood. In [4, 1,000,000].
  uint32_t max_neighbor_count = 10'000;
  // Bytes that all calls together may hold for clouds, indices, results and messages; 0: 80 % of the smaller of the
  // control group's limit and the machine's memory. At least 32 MiB.
  uint64_t memory_limit_bytes = 0;
  // Calls that may be open at a time. In [1, 100,000].
  uint32_t max_streams = 1'000;
  // Calls that one caller (its token, its certificate, else its address) may have open at a time. In [1, 100,000].
  uint32_t max_streams_per_peer = 500;
  // Connections that may be open at a time, and how many of them from one address. In [1, 1,000,000]. Fewer where the
  // process may not open as many descriptors.
  uint32_t max_connections = 2'000;
  uint32_t max_connections_per_peer = 100;
  // Bytes of one call's metadata. In [1 KiB, 1 MiB]. A stranger may send as much, and 88 KiB (ByteAllowances).
  uint32_t max_header_bytes = 8 << 10;
  // How long a connection may be without a call. > 0.
  absl::Duration idle_timeout = absl::Minutes(10);
  // How long a connection may take until its handshake is done. > 0.
  absl::Duration handshake_timeout = absl::Seconds(10);
  // While a call is open: for how long a peer may be silent until it is asked whether it is there, and how long it may
  // take to answer. > 0. No flags: clients and docs rely on 15 seconds together.
  absl::Duration keepalive_time = absl::Milliseconds(kKeepaliveTimeMs);
  absl::Duration keepalive_timeout = absl::Milliseconds(kKeepaliveTimeoutMs);
  // Calls that may wait for memory at a time; further ones are refused. In [0, 100,000].
  uint32_t max_waiting = 500;

  // Whether the process is there for this server alone, so that its memory is held against memory_limit_bytes and
  // strangers' connections are ended where it is much more. No flag: curvd's is.
  bool owns_process = false;

  // How long calls that were accepted before a drain may take to finish.
  absl::Duration drain_timeout = absl::Seconds(30);
  // How long a call may keep the server waiting for points, or for room to send its results. While others wait for
  // memory, also over how long its points, or results, must move at 16 KiB a second (server/rpc/peer_pace.h). > 0.
  absl::Duration stall_timeout = absl::Minutes(5);
  // One structured line on stderr for each call.
  bool log = true;

  // INVALID_ARGUMENT naming the flag, its value and its limit if a value is out of its range (ports too), or if
  // `listen` could be reached from other machines with neither TLS nor `insecure`.
  absl::Status Validate() const;
  // Bytes of the largest message that gRPC takes: a chunk, and what protobuf and a careless client may add to it, so
  // that the client gets our error and not gRPC's.
  uint64_t max_message_bytes() const { return max_chunk_bytes + (1 << 20); }
  // The same with numbers for `threads` and `memory_limit_bytes`, whatever this machine has where they are 0.
  ServerOptions Resolved() const;
};

}  // namespace curvd
