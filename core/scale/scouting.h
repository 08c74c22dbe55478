// What the first of the sampled points tell about the others.
#pragma once

#include <cstddef>
#include <optional>

#include "core/estimators/options.h"
#include "core/estimators/scale_ladder.h"
#include "core/index/spatial_index.h"
#include "core/scale/edges/edge_run.h"
#include "core/scale/pilot/pilot.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Scouts are sampled at the first rungs, and at all of them only where these do not tell what the other points need. Of
// a small exact cloud, scouts at all rungs took half of the time of the whole choice.
//
// Usage: sample the scouts; ask LooksAgain, and sample them once more if it says so; once edges are known, the same
// with LooksAgainAtEdges; then SpareOthers, and sample the others.
class Scouting {
 public:
  // Leaves the first rungs to the pilot, if they may be enough. Everything outlives the object. `edges`: null where
  // nobody minds them.
  Scouting(const EstimatorOptions& options, const SpatialIndex& index, Pilot& pilot, PilotTable& table,
           const EdgeRun* edges);

  // Whether the scouts are to be sampled at all rungs: then the table is empty again.
  bool LooksAgain();
  // The same where there are edges: few scouts may be clear of them at the rungs that others need. REQUIRES: the edges
  // are finished.
  bool LooksAgainAtEdges();
  // The others are spared the rungs far beyond those that count at the scouts, and the methods that do not count there.
  void SpareOthers();

 private:
  struct Needed {
    size_t rungs;
    MethodSet methods;
  };
  // What others need, as the scouts tell it. Nothing where they do not.
  std::optional<Needed> NeededByOthers() const;
  void SampleAllRungs();

  const EstimatorOptions& options_;
  const SpatialIndex& index_;
  Pilot& pilot_;
  PilotTable& table_;
  const EdgeRun* const edges_;
  bool are_brief_;  // whether the scouts have the first rungs only
  std::optional<Needed> needed_;
};

}  // namespace curvd
