// A gRPC server with the health service alone, and with what gRPC itself has against strangers: to find out what that
// is worth (tests/fault/grpc_arguments.py).
//
//   fault_unguarded [--quota-mib=N] [--max-metadata=BYTES] [--max-streams=N] [--hpack-table=BYTES]
// Prints its port, and serves until it is killed.
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

namespace curvd {
namespace {

int Main(int argc, char** argv) {
  size_t quota_mib = 0;
  int max_metadata = -1, max_streams = -1, hpack_table = -1;
  CLI::App app("A gRPC server with the health service alone", "fault_unguarded");
  app.add_option("--quota-mib", quota_mib, "memory of a ResourceQuota");
  app.add_option("--max-metadata", max_metadata, "GRPC_ARG_MAX_METADATA_SIZE");
  app.add_option("--max-streams", max_streams, "GRPC_ARG_MAX_CONCURRENT_STREAMS");
  app.add_option("--hpack-table", hpack_table, "GRPC_ARG_HTTP2_HPACK_TABLE_SIZE_DECODER");
  CLI11_PARSE(app, argc, argv);

  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  if (quota_mib > 0) {
    grpc::ResourceQuota quota("strangers");
    quota.Resize(quota_mib << 20);
    builder.SetResourceQuota(quota);
  }
  if (max_metadata >= 0) builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, max_metadata);
  if (max_streams >= 0) builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, max_streams);
  if (hpack_table >= 0) builder.AddChannelArgument(GRPC_ARG_HTTP2_HPACK_TABLE_SIZE_DECODER, hpack_table);
  grpc::CallbackGenericService nothing_else;
  builder.RegisterCallbackGenericService(&nothing_else);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  std::printf("%d\n", port);
  std::fflush(stdout);
  server->Wait();
  return 0;
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
