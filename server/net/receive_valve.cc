#include "server/net/receive_valve.h"

#include <linux/filter.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/ip6.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cstring>

namespace curvd {
namespace {

constexpr uint32_t kSequenceOffset = 4;       // of the sequence number in a TCP header
constexpr uint32_t kHeaderLengthOffset = 12;  // its upper four bits: words of the header
constexpr uint32_t kLowerHalf = uint32_t{1} << 31;

}  // namespace

void RememberBeginnings(int listener) {
  constexpr int yes = 1;
  setsockopt(listener, IPPROTO_TCP, TCP_SAVE_SYN, &yes, sizeof(yes));
}

std::optional<uint32_t> BeginningOf(int fd) {
  std::array<unsigned char, 256> opening;  // the headers of the peer's SYN
  socklen_t length = opening.size();
  if (getsockopt(fd, IPPROTO_TCP, TCP_SAVED_SYN, opening.data(), &length) != 0 || length < sizeof(iphdr)) {
    return std::nullopt;
  }
  const bool is_v4 = opening[0] >> 4 == 4;
  // A SYN with extension headers of IPv6 is not understood.
  if (!is_v4 && (length < sizeof(ip6_hdr) || opening[offsetof(ip6_hdr, ip6_nxt)] != IPPROTO_TCP)) return std::nullopt;
  const size_t tcp = is_v4 ? size_t{4} * (opening[0] & 15) : sizeof(ip6_hdr);
  uint32_t sequence = 0;
  if (length < tcp + kSequenceOffset + sizeof(sequence)) return std::nullopt;
  std::memcpy(&sequence, opening.data() + tcp + kSequenceOffset, sizeof(sequence));
  return ntohl(sequence) + 1;
}

bool BoundReceived(int fd, uint32_t beginning, uint64_t bytes) {
  const uint32_t end = beginning + static_cast<uint32_t>(bytes);
  // Keeps of each segment its header and the bytes before `end`.
  std::array<sock_filter, 14> program = {{
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kHeaderLengthOffset),
      BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0xf0),
      BPF_STMT(BPF_ALU | BPF_RSH | BPF_K, 2),
      BPF_STMT(BPF_ST, 0),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kSequenceOffset),
      BPF_STMT(BPF_MISC | BPF_TAX, 0),
      BPF_STMT(BPF_LD | BPF_IMM, end),
      BPF_STMT(BPF_ALU | BPF_SUB | BPF_X, 0),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kLowerHalf, 0, 1),  // the segment begins behind the end
      BPF_STMT(BPF_LD | BPF_IMM, 0),
      BPF_STMT(BPF_MISC | BPF_TAX, 0),
      BPF_STMT(BPF_LD | BPF_MEM, 0),
      BPF_STMT(BPF_ALU | BPF_ADD | BPF_X, 0),
      BPF_STMT(BPF_RET | BPF_A, 0),
  }};
  const sock_fprog filter = {static_cast<unsigned short>(program.size()), program.data()};
  return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter)) == 0;
}

void LiftBound(int fd) {
  constexpr int unused = 0;
  setsockopt(fd, SOL_SOCKET, SO_DETACH_FILTER, &unused, sizeof(unused));
}

}  // namespace curvd
