#include "core/job/phases/index_phases.h"

namespace curvd {
namespace {

class CollectPhase final : public Phase {
 public:
  explicit CollectPhase(IndexBuilder& builder) : builder_(builder) {}
  std::string_view name() const override { return kIndexPhase; }
  absl::StatusOr<size_t> Begin() override { return builder_.block_count(); }
  absl::Status RunBlock(const BlockContext& context) override {
    builder_.RunBlock(context.block);
    return absl::OkStatus();
  }
  absl::Status End() override {
    builder_.EndPhase();
    return absl::OkStatus();
  }

 private:
  IndexBuilder& builder_;
};

class TreePhase final : public Phase {
 public:
  explicit TreePhase(IndexBuilder& builder) : builder_(builder) {}
  std::string_view name() const override { return kIndexPhase; }
  absl::StatusOr<size_t> Begin() override { return 1; }
  absl::Status RunBlock(const BlockContext& context) override {
    builder_.Build(builder_.PartOf(context.block),
                   [&context](const IndexBuilder::Part& half) { context.add_block(half.node); });
    return absl::OkStatus();
  }

 private:
  IndexBuilder& builder_;
};

}  // namespace

std::unique_ptr<Phase> MakeCollectPhase(IndexBuilder& builder) { return std::make_unique<CollectPhase>(builder); }

std::unique_ptr<Phase> MakeTreePhase(IndexBuilder& builder) { return std::make_unique<TreePhase>(builder); }

}  // namespace curvd
