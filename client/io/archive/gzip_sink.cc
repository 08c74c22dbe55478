#include "client/io/archive/gzip_sink.h"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <string>

namespace curv {

struct GzipSink::Stream {
  z_stream deflate{};
  std::string packed = std::string(size_t{1} << 18, '\0');
};

GzipSink::GzipSink(ByteSink& target) : target_(target), stream_(std::make_unique<Stream>()) {
  constexpr int kGzipWindow = 15 + 16, kMemoryLevel = 8;
  if (deflateInit2(&stream_->deflate, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();  // the one way in which these arguments can fail
  }
}

GzipSink::~GzipSink() { deflateEnd(&stream_->deflate); }

absl::Status GzipSink::Append(std::string_view bytes) {
  constexpr size_t kMostAtOnce = size_t{1} << 30;  // zlib counts in 32 bits
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), kMostAtOnce))) {
    if (absl::Status status = Deflate(bytes.substr(0, kMostAtOnce), Z_NO_FLUSH); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status GzipSink::Finish() { return Deflate({}, Z_FINISH); }

absl::Status GzipSink::Deflate(std::string_view bytes, int flush) {
  z_stream& stream = stream_->deflate;
  // zlib does not write to its input, though its type says that it could.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  do {
    stream.next_out = reinterpret_cast<Bytef*>(stream_->packed.data());
    stream.avail_out = static_cast<uInt>(stream_->packed.size());
    deflate(&stream, flush);
    const size_t packed = stream_->packed.size() - stream.avail_out;
    if (packed == 0) continue;
    absl::Status status = target_.Append(std::string_view(stream_->packed).substr(0, packed));
    if (!status.ok()) return status;
  } while (stream.avail_out == 0);
  return absl::OkStatus();
}

}  // namespace curv
