#include "client/cli/connection.h"

#include <utility>
#include <variant>

#include "client/cli/progress_bar.h"
#include "server/curvature_server.h"

namespace curv {
namespace {

class RemoteConnection : public Connection {
 public:
  explicit RemoteConnection(std::unique_ptr<CurvatureClient> client) : client_(std::move(client)) {}
  const CurvatureClient& client() const override { return *client_; }

 private:
  std::unique_ptr<CurvatureClient> client_;
};

class EmbeddedConnection : public Connection {
 public:
  explicit EmbeddedConnection(std::unique_ptr<curvd::CurvatureServer> server)
      : server_(std::move(server)), client_(server_->InProcessChannel()) {}
  const CurvatureClient& client() const override { return client_; }

 private:
  std::unique_ptr<curvd::CurvatureServer> server_;
  CurvatureClient client_;
};

template <typename Scalar>
CloudView ViewOf(const PackedCloud<Scalar>& packed) {
  CloudView view(packed.positions, packed.normals);
  if (!packed.viewpoints.empty()) view = view.SeenFrom(packed.viewpoints);
  return packed.directions.empty() ? view : view.Toward(packed.directions);
}

}  // namespace

absl::StatusOr<CurvatureResult> CallServer(const Connection& connection, const OrientedCloud& cloud,
                                           const EstimateOptions& options, const std::stop_token& stop,
                                           const std::optional<BatchShare>& share) {
  ProgressBar bar(share);
  const EstimateCallbacks callbacks{[&bar](const EstimateProgress& progress) { bar.Show(progress); }, stop};
  return std::visit(
      [&](const auto& packed) { return connection.client().Estimate(ViewOf(packed), options, callbacks); }, cloud);
}

absl::StatusOr<std::unique_ptr<Connection>> Connection::Create(const ConnectionFlags& flags, int threads) {
  if (!flags.server.empty()) {
    const absl::StatusOr<ConnectOptions> connect = ReadConnectOptions(flags);
    if (!connect.ok()) return connect.status();
    absl::StatusOr<std::unique_ptr<CurvatureClient>> client = CurvatureClient::Connect(flags.server, *connect);
    if (!client.ok()) return client.status();
    return std::make_unique<RemoteConnection>(*std::move(client));
  }
  if (absl::Status status = CheckNoneNeedsAServer(flags); !status.ok()) return status;
  curvd::ServerOptions options;
  options.listen = "";
  options.metrics_listen = "";
  options.threads = threads;
  options.log = false;
  // The only user is the one who asked.
  options.max_points = (uint64_t{1} << 31) - 1;
  options.max_neighbor_count = 1'000'000;
  absl::StatusOr<std::unique_ptr<curvd::CurvatureServer>> server = curvd::CurvatureServer::Create(options);
  if (!server.ok()) return server.status();
  return std::make_unique<EmbeddedConnection>(*std::move(server));
}

}  // namespace curv
