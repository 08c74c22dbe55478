// Packs what is written with gzip (RFC 1952).
#pragma once

#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "client/io/byte_sink.h"

namespace curv {

// Not thread-safe.
class GzipSink : public ByteSink {
 public:
  // Packed bytes go to `target`, which must outlive the sink.
  explicit GzipSink(ByteSink& target);
  ~GzipSink() override;

  absl::Status Append(std::string_view bytes) override;
  // Writes what is left. Called once, after the last Append. Errors are those of the target.
  absl::Status Finish();

 private:
  struct Stream;
  absl::Status Deflate(std::string_view bytes, int flush);

  ByteSink& target_;
  std::unique_ptr<Stream> stream_;
};

}  // namespace curv
