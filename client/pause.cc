#include "client/pause.h"

#include "absl/synchronization/notification.h"

namespace curv {

bool PauseFor(absl::Duration duration, const std::stop_token& stop) {
  absl::Notification stopped;
  const std::stop_callback on_stop(stop, [&stopped] { stopped.Notify(); });
  return !stopped.WaitForNotificationWithTimeout(duration);
}

}  // namespace curv
