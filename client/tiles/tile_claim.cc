#include "client/tiles/tile_claim.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"

namespace curv {
namespace {

std::string LockPath(const TilePlan& plan, size_t tile) {
  return plan.PathOf(absl::StrFormat("locks/tile-%06d", tile));
}

}  // namespace

std::optional<TileClaim> TileClaim::Try(const TilePlan& plan, size_t tile) {
  const int descriptor = open(LockPath(plan, tile).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) return TileClaim(-1);
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return TileClaim(descriptor);
  const bool is_held = errno == EWOULDBLOCK;
  close(descriptor);
  if (is_held) return std::nullopt;
  return TileClaim(-1);
}

bool TileClaim::IsHeld(const TilePlan& plan, size_t tile) {
  const int descriptor = open(LockPath(plan, tile).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_held = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return is_held;
}

TileClaim::TileClaim(TileClaim&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

TileClaim::~TileClaim() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace curv
