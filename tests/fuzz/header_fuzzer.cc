// Resolves any CloudHeader.
#include <cstddef>
#include <cstdint>

#include "curvature/v1/curvature.pb.h"
#include "server/call/header_options.h"
#include "server/server_options.h"
#include "tests/fuzz/error_properties.h"
#include "tests/fuzz/require.h"

namespace {

namespace v1 = curvature::v1;
using curvd::CallOptions;

const curvd::CallLimits& Limits() {
  static const curvd::ServerOptions options;
  static const curvd::CallLimits limits = {options.max_points, options.max_chunk_bytes, options.max_neighbor_count,
                                           uint64_t{8} << 30, options.max_streams};
  return limits;
}

v1::Accepted AcceptedFor(const CallOptions& options) {
  v1::Accepted accepted;
  curvd::FillAccepted(options, Limits(), "0badcafe-7", &accepted);
  return accepted;
}

// Accepted says what the call uses: the same header with those options must resolve to the same.
void CheckAccepted(const v1::CloudHeader& header, const CallOptions& options) {
  const v1::Accepted accepted = AcceptedFor(options);
  v1::CloudHeader resolved = header;
  *resolved.mutable_options() = accepted.options();
  *resolved.mutable_quantities() = accepted.quantities();
  *resolved.mutable_normals() = accepted.normals();
  const absl::StatusOr<CallOptions> again = curvd::ResolveHeader(resolved, Limits());
  fuzz::Require(again.ok(), "resolved options are valid");
  fuzz::Require(AcceptedFor(*again).SerializeAsString() == accepted.SerializeAsString(),
                "resolved options resolve to themselves");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  v1::CloudHeader header;
  if (!header.ParseFromArray(bytes, static_cast<int>(size))) return 0;
  const absl::StatusOr<CallOptions> options = curvd::ResolveHeader(header, Limits());
  if (!options.ok()) {
    fuzz::CheckRequestError(options.status());
    return 0;
  }
  fuzz::Require(options->estimator.Validate().ok(), "the estimator takes resolved options");
  fuzz::Require(options->normals.Validate(0).ok(), "normals take resolved options");
  fuzz::Require(options->request_tag.empty() || fuzz::IsShowable(options->request_tag), "tags are printable");
  CheckAccepted(header, *options);
  return 0;
}
