#include "tests/integration/raw_http2_call.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace curvd {
namespace {

constexpr char kData = 0x0, kHeaders = 0x1, kReset = 0x3, kSettings = 0x4, kGoAway = 0x7;
constexpr uint32_t kInitialWindowSize = 0x4;
constexpr char kEndStream = 0x1, kEndHeaders = 0x4;
constexpr size_t kFrameHeaderBytes = 9, kMessagePrefixBytes = 5;

std::string BigEndian(uint32_t number, int bytes) {
  std::string packed;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) packed += static_cast<char>(number >> shift);
  return packed;
}

uint32_t ReadBigEndian(const std::string& bytes, size_t at, size_t count) {
  uint32_t number = 0;
  for (size_t i = 0; i < count; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

// HPACK: a string as it is, without Huffman's code. REQUIRES: fewer than 127 bytes.
std::string HpackString(const std::string& text) { return static_cast<char>(text.size()) + text; }

std::string CallHeaders() {
  // Indexed :method POST and :scheme http; then literals that stay out of the table, by index of their name or with it.
  return "\x83\x86\x04" + HpackString("/curvature.v1.CurvatureService/EstimateCurvature") + "\x01" +
         HpackString("localhost") + "\x0f\x10" + HpackString("application/grpc") + std::string(1, '\0') +
         HpackString("te") + HpackString("trailers");
}

// The value of grpc-status in a header block, which gRPC writes as literals.
std::string StatusIn(const std::string& block) {
  const std::string name = "grpc-status";
  const size_t found = block.find(name);
  if (found == std::string::npos) return "";
  const size_t length = found + name.size();
  return block.substr(length + 1, static_cast<unsigned char>(block[length]));
}

}  // namespace

RawHttp2Call::RawHttp2Call(int port, uint32_t window) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  const std::string preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
  EXPECT_EQ(send(fd_, preface.data(), preface.size(), MSG_NOSIGNAL), static_cast<ssize_t>(preface.size()));
  SendFrame(kSettings, 0, 0, BigEndian(kInitialWindowSize, 2) + BigEndian(window, 4));
  SendFrame(kHeaders, kEndHeaders, 1, CallHeaders());
}

RawHttp2Call::~RawHttp2Call() { close(fd_); }

void RawHttp2Call::SendFrame(char type, char flags, int stream, const std::string& payload) {
  const std::string frame = BigEndian(static_cast<uint32_t>(payload.size()), 3) + type + flags +
                            BigEndian(static_cast<uint32_t>(stream), 4) + payload;
  EXPECT_EQ(send(fd_, frame.data(), frame.size(), MSG_NOSIGNAL), static_cast<ssize_t>(frame.size()));
}

void RawHttp2Call::SendBytes(const std::string& bytes, bool end_stream) {
  SendFrame(kData, end_stream ? kEndStream : 0, 1, bytes);
}

void RawHttp2Call::SendTrailers() {
  SendFrame(kHeaders, kEndStream | kEndHeaders, 1, std::string(1, '\0') + HpackString("x-end") + HpackString("1"));
}

std::string RawHttp2Call::Framed(const curvature::v1::EstimateCurvatureRequest& message) {
  const std::string bytes = message.SerializeAsString();
  return std::string(1, '\0') + BigEndian(static_cast<uint32_t>(bytes.size()), 4) + bytes;
}

std::string RawHttp2Call::Receive(size_t size) {
  std::string bytes(size, '\0');
  const ssize_t count = size == 0 ? 0 : recv(fd_, bytes.data(), size, MSG_WAITALL);
  bytes.resize(count < 0 ? 0 : static_cast<size_t>(count));
  return bytes;
}

RawHttp2Result RawHttp2Call::Finish() {
  RawHttp2Result result;
  std::string stream;
  for (;;) {
    const std::string header = Receive(kFrameHeaderBytes);
    if (header.size() < kFrameHeaderBytes) {
      ADD_FAILURE() << "the server closed the connection";
      break;
    }
    const std::string payload = Receive(ReadBigEndian(header, 0, 3));
    const char type = header[3], flags = header[4];
    if (type == kReset || type == kGoAway) ADD_FAILURE() << "the server broke the stream off";
    if (type == kData) stream += payload;
    if (type == kHeaders && (flags & kEndStream) != 0) result.grpc_status = StatusIn(payload);
    if (type == kReset || type == kGoAway || (type == kHeaders && (flags & kEndStream) != 0)) break;
  }
  for (size_t at = 0; at + kMessagePrefixBytes <= stream.size();) {
    const size_t size = ReadBigEndian(stream, at + 1, 4);
    result.responses.emplace_back();
    EXPECT_TRUE(result.responses.back().ParseFromString(stream.substr(at + kMessagePrefixBytes, size)));
    at += kMessagePrefixBytes + size;
  }
  return result;
}

}  // namespace curvd
