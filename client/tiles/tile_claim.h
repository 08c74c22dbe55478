// Keeps processes from doing one tile at a time twice. That would do no harm, but takes time.
#pragma once

#include <cstddef>
#include <optional>

#include "client/tiles/tile_plan.h"

namespace curv {

// A lock that the system takes back when its process ends, however it ends. Where the file system knows no locks, all
// claims succeed.
class TileClaim {
 public:
  // Nothing if somebody, on this machine or one that shares the file system, has the claim.
  static std::optional<TileClaim> Try(const TilePlan& plan, size_t tile);
  // Whether somebody has it.
  static bool IsHeld(const TilePlan& plan, size_t tile);

  TileClaim(TileClaim&& other) noexcept;
  TileClaim& operator=(TileClaim&&) = delete;
  ~TileClaim();

 private:
  explicit TileClaim(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;  // -1 if there is nothing to give back
};

}  // namespace curv
