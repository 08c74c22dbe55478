// Phases that are made of functions, where a class of their own would say no more.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include "core/base/phase.h"

namespace curvd {

// What a phase calls, as the methods of Phase: `run` on many threads at once.
struct PhaseFunctions {
  std::function<absl::StatusOr<size_t>()> begin;
  std::function<absl::Status(const BlockContext& context)> run;
  std::function<absl::Status()> end = [] { return absl::OkStatus(); };
};

class FunctionPhase final : public Phase {
 public:
  // What the functions refer to outlives the phase.
  FunctionPhase(std::string_view name, PhaseFunctions functions) : name_(name), functions_(std::move(functions)) {}

  std::string_view name() const override { return name_; }
  absl::StatusOr<size_t> Begin() override { return functions_.begin(); }
  absl::Status RunBlock(const BlockContext& context) override { return functions_.run(context); }
  absl::Status End() override { return functions_.end(); }

 private:
  const std::string_view name_;
  const PhaseFunctions functions_;
};

// Calls `step`, and has no blocks.
inline std::unique_ptr<Phase> MakeStep(std::string_view name, std::function<absl::Status()> step) {
  return std::make_unique<FunctionPhase>(name,
                                         PhaseFunctions{.begin = [] { return size_t{0}; },
                                                        .run = [](const BlockContext&) { return absl::OkStatus(); },
                                                        .end = std::move(step)});
}

// Runs the blocks that a probe has when the phase begins: block_count() calls of RunBlock(block, worker, stopped).
// REQUIRES: the probe outlives the phase.
template <typename Probe>
std::unique_ptr<Phase> MakeProbePhase(std::string_view name, Probe& probe) {
  const auto run = [&probe](const BlockContext& context) {
    return probe.RunBlock(context.block, context.worker, context.stopped);
  };
  return std::make_unique<FunctionPhase>(name,
                                         PhaseFunctions{.begin = [&probe] { return probe.block_count(); }, .run = run});
}

// Calls run(first, last) for runs of at most so many of the numbers below `count`, which together hold each of them
// once; then `end`.
inline std::unique_ptr<Phase> MakeLoop(
    std::string_view name, size_t count, size_t most_in_block, std::function<void(size_t first, size_t last)> run,
    std::function<absl::Status()> end = [] { return absl::OkStatus(); }) {
  const auto begin = [=] { return (count + most_in_block - 1) / most_in_block; };
  const auto run_block = [=, run = std::move(run)](const BlockContext& context) {
    const size_t first = context.block * most_in_block;
    run(first, std::min(first + most_in_block, count));
    return absl::OkStatus();
  };
  return std::make_unique<FunctionPhase>(name, PhaseFunctions{begin, run_block, std::move(end)});
}

}  // namespace curvd
