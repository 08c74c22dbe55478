#include "client/curvature_client.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <span>
#include <utility>
#include <variant>

#include "absl/random/random.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/channels.h"
#include "client/estimate_attempt.h"
#include "client/pause.h"
#include "client/server_info.h"
#include "grpcpp/channel.h"
#include "proto/result_columns.h"

namespace curv {
namespace {

// Does not jump when somebody sets the machine's time.
using Clock = std::chrono::steady_clock;

// Checks an array that comes with the positions if it `is_wanted`; `remedy` is for one that does not fit.
absl::Status CheckArray(const CloudView& cloud, const char* name, std::span<const std::byte> array, bool is_wanted,
                        const char* remedy) {
  const size_t scalar_bytes = cloud.point_bytes() / 3, wanted = is_wanted ? cloud.positions().size() : 0;
  if (array.size() == wanted) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("positions hold ", cloud.positions().size() / scalar_bytes,
                                                 " scalars and ", name, " ", array.size() / scalar_bytes, ": ",
                                                 remedy));
}

absl::Status CheckDirections(const CloudView& cloud, const EstimateOptions& options) {
  const bool is_asked =
      std::find(options.quantities.begin(), options.quantities.end(), "normal_curvature") != options.quantities.end();
  const bool has_directions = is_asked && !options.curvature_direction;
  return CheckArray(cloud, "directions", cloud.directions(), has_directions,
                    has_directions
                        ? "the quantity normal_curvature needs one at each point, or options.curvature_direction"
                        : "only the quantity normal_curvature without options.curvature_direction takes them");
}

absl::Status CheckArrays(const CloudView& cloud, const EstimateOptions& options) {
  const NormalOptions& normals = options.normals;
  if (cloud.positions().size() % cloud.point_bytes() != 0) {
    return absl::InvalidArgumentError(absl::StrCat("positions hold ",
                                                   3 * cloud.positions().size() / cloud.point_bytes(),
                                                   " scalars: they must hold three for each point"));
  }
  const bool has_normals = normals.source != NormalSource::kEstimate;
  const char* remedy = !has_normals ? "options.normals.source asks for estimated ones, so that none may be given"
                       : cloud.normals().empty() ? "set options.normals.source to kEstimate, and the server makes them"
                                                 : "both must hold three for each point, as many";
  absl::Status status = CheckArray(cloud, "normals", cloud.normals(), has_normals, remedy);
  if (!status.ok()) return status;
  const bool has_viewpoints =
      normals.source != NormalSource::kGiven && std::holds_alternative<SidesTowardViewpoints>(normals.sides);
  status = CheckArray(cloud, "viewpoints", cloud.viewpoints(), has_viewpoints,
                      has_viewpoints ? "options.normals.sides asks for one at each point"
                                     : "only SidesTowardViewpoints of options.normals.sides takes them");
  return status.ok() ? CheckDirections(cloud, options) : status;
}

std::vector<std::string> ListDefaultQuantityNames() {
  std::vector<std::string> names;
  for (const auto& column : curvature::wire::ResultColumns()) {
    if (column.on_request || column.quantity == curvature::v1::QUANTITY_UNSPECIFIED) continue;
    const std::string name = curvature::wire::QuantityName(column.quantity);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

absl::Status CheckPart(const CloudView& cloud) {
  const auto check = [&](const char* name, size_t size) {
    if (size == 0 || size == cloud.size()) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(name, " holds ", size, " entries: it must hold one for each of ",
                                                   cloud.size(), " points, or none"));
  };
  absl::Status status = check("ids", cloud.ids().size());
  return status.ok() ? check("roles", cloud.roles().size()) : status;
}

std::vector<std::string> ListQuantityNames() {
  std::vector<std::string> names;
  for (const auto quantity : curvature::wire::Quantities()) names.push_back(curvature::wire::QuantityName(quantity));
  return names;
}

absl::Status CheckQuantities(const std::vector<std::string>& quantities) {
  for (auto it = quantities.begin(); it != quantities.end(); ++it) {
    if (!curvature::wire::QuantityOf(*it)) {
      return absl::InvalidArgumentError(
          absl::StrCat("quantities has \"", *it, "\"; it must be among ", absl::StrJoin(QuantityNames(), ", ")));
    }
    if (std::find(quantities.begin(), it, *it) != it) {
      return absl::InvalidArgumentError(absl::StrCat("quantities has \"", *it, "\" twice; once is enough"));
    }
  }
  return absl::OkStatus();
}

// What to wait before the next attempt: at least what the server asked for, nothing where `another` server may take the
// cloud at once, else doubling from 0.25 s, up to a quarter less so that clients do not come in step.
absl::Duration PauseAfter(int attempt, absl::Duration asked, bool another) {
  if (attempt == 1 && another) return asked;
  absl::BitGen bits;
  const double jitter = absl::Uniform(bits, 0.75, 1.0);
  return std::max(asked, jitter * absl::Milliseconds(250) * static_cast<double>(1 << std::min(attempt - 1, 5)));
}

// Gives a server that may have come back the time to take a connection. A call of its own would not: while the channel
// knows of the failure alone it fails at once, and between calls nobody drives a connection on.
void AwaitConnection(const std::shared_ptr<grpc::Channel>& channel, absl::Duration at_most,
                     const std::stop_token& stop) {
  constexpr auto kStep = std::chrono::milliseconds(50);
  const auto steps = std::min(at_most, absl::Seconds(1)) / absl::FromChrono(kStep);
  grpc::experimental::ChannelResetConnectionBackoff(channel.get());
  for (int step = 0; step < steps && !stop.stop_requested(); ++step) {
    if (channel->WaitForConnected(std::chrono::system_clock::now() + kStep)) return;
  }
}

}  // namespace

const std::vector<std::string>& DefaultQuantityNames() {
  static const auto& names = *new std::vector<std::string>(ListDefaultQuantityNames());
  return names;
}

const std::vector<std::string>& QuantityNames() {
  static const auto& names = *new std::vector<std::string>(ListQuantityNames());
  return names;
}

absl::StatusOr<std::unique_ptr<CurvatureClient>> CurvatureClient::Connect(std::string_view servers,
                                                                          const ConnectOptions& options) {
  absl::StatusOr<std::unique_ptr<Channels>> channels = Channels::Create(servers, options);
  if (!channels.ok()) return channels.status();
  return std::unique_ptr<CurvatureClient>(new CurvatureClient(*std::move(channels)));
}

CurvatureClient::CurvatureClient(std::shared_ptr<grpc::Channel> channel)
    : channels_(std::make_unique<Channels>(std::vector{std::move(channel)}, 0)) {}
CurvatureClient::CurvatureClient(std::unique_ptr<Channels> channels) : channels_(std::move(channels)) {}
CurvatureClient::~CurvatureClient() = default;

absl::StatusOr<CurvatureResult> CurvatureClient::Estimate(const CloudView& cloud, const EstimateOptions& options,
                                                          const EstimateCallbacks& callbacks) const {
  if (absl::Status status = CheckArrays(cloud, options); !status.ok()) return status;
  if (absl::Status status = CheckPart(cloud); !status.ok()) return status;
  if (absl::Status status = CheckQuantities(options.quantities); !status.ok()) return status;
  const Clock::time_point start = Clock::now();
  const auto left_of = [&](absl::Duration limit) { return limit - absl::FromChrono(Clock::now() - start); };
  const auto limit = [&] {
    return channels_->reached() ? options.timeout : std::min(options.timeout, options.connect_timeout);
  };
  for (int attempt = 1;; ++attempt) {
    const std::shared_ptr<grpc::Channel> channel = channels_->Next();
    if (attempt > 1 && channels_->connect()) AwaitConnection(channel, left_of(limit()), callbacks.stop);
    AttemptOutcome outcome = RunAttempt(channel, cloud, options, left_of(options.timeout), attempt, callbacks);
    if (outcome.result) {
      channels_->SetReached();
      outcome.result->summary.attempts = attempt;
      return *std::move(outcome.result);
    }
    const AttemptFailure& failure = outcome.failure;
    if (failure.answered) channels_->SetReached();
    if (!failure.retry_after || attempt >= options.max_attempts) return channels_->Explain(failure.status);
    const absl::Duration pause = PauseAfter(attempt, *failure.retry_after, channels_->size() > 1);
    // Another server has its turn, however long the first kept silent.
    const bool all_were_tried = static_cast<size_t>(attempt) >= channels_->size();
    if (pause >= left_of(all_were_tried ? limit() : options.timeout)) return channels_->Explain(failure.status);
    if (!PauseFor(pause, callbacks.stop)) return absl::CancelledError("cancelled while waiting for a server");
  }
}

absl::StatusOr<ServerInfo> CurvatureClient::GetServerInfo(absl::Duration timeout) const {
  return AskAny<ServerInfo>(AskServer, timeout);
}

absl::StatusOr<std::string> CurvatureClient::GetHealth(absl::Duration timeout) const {
  return AskAny<std::string>(AskHealth, timeout);
}

template <typename Answer, typename Ask>
absl::StatusOr<Answer> CurvatureClient::AskAny(Ask ask, absl::Duration timeout) const {
  absl::StatusOr<Answer> answer;
  for (size_t i = 0; i < channels_->size(); ++i) {
    answer = ask(channels_->Next(), timeout);
    if (answer.ok() || !absl::IsUnavailable(answer.status())) break;
  }
  if (!answer.ok()) return channels_->Explain(answer.status());
  return answer;
}

}  // namespace curv
