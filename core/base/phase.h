// One step of a job: work that is cut into blocks which workers run side by side.
#pragma once

#include <atomic>
#include <cstddef>
#include <string_view>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace curvd {

// What a phase is told with each block that it runs.
struct BlockContext {
  size_t block;
  // Which thread runs the block, in [0, thread_count()) of the pool: for scratch that threads do not share.
  int worker;
  // Whether nobody wants the result any more: the job was cancelled, or it failed in another block. A phase whose
  // blocks take more than a few milliseconds looks at it in between, and returns OK when it is set.
  const std::atomic<bool>& stopped;
  // Gives the phase one more block, which may begin at once on any thread. The phase ends after all of its blocks.
  absl::FunctionRef<void(size_t block)> add_block;
};

// A job begins its phases one after the other (core/job/phased_job.h). Begin and End are called once each, and nothing
// else runs meanwhile; RunBlock is called on many threads at once. A phase may throw std::bad_alloc anywhere: the job
// then ends with ErrorKind::kOutOfMemory. It must not throw anything else.
class Phase {
 public:
  virtual ~Phase() = default;

  // The word under which progress and cost tell of this phase; phases in a row may share one. The text outlives the
  // job.
  virtual std::string_view name() const = 0;

  // Prepares the phase and returns how many blocks it begins with; it may be none. An error ends the job.
  virtual absl::StatusOr<size_t> Begin() = 0;

  // Runs one block. An error ends the job, and leaves out the blocks that have not begun.
  virtual absl::Status RunBlock(const BlockContext& context) = 0;

  // Called once all blocks have returned OK. An error ends the job.
  virtual absl::Status End() { return absl::OkStatus(); }
};

}  // namespace curvd
