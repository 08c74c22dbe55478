// Health and reflection, whose protos are written out as bytes: a field of strings is its tag, its length, its text.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

namespace curvd {

std::string BytesOf(const grpc::ByteBuffer& buffer);
grpc::ByteBuffer BufferOf(const std::string& bytes);
// REQUIRES: number < 16, fewer than 128 bytes of text.
std::string StringField(int number, const std::string& text);

inline constexpr char kServing[] = "\x08\x01";     // status: SERVING
inline constexpr char kNotServing[] = "\x08\x02";  // status: NOT_SERVING

// Asks grpc.health.v1 for `service`; `answer` is the bytes of the response.
grpc::Status CheckHealth(const std::shared_ptr<grpc::Channel>& channel, const std::string& service,
                         std::string* answer);

}  // namespace curvd
