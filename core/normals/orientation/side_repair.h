// Chooses the sides of the clusters of a piece so that they fit a closed surface, where the tree of cheapest links went
// wrong: a plate as thin as its points are apart has links across that are as cheap as those along its faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/normals/orientation/winding_field.h"

namespace curvd {

// One piece's sides, and how well they fit. Not thread-safe, but Descend.
class SideRepair {
 public:
  // Searches that Descend runs, each from other sides.
  static constexpr size_t kStarts = 16;

  // `turned`: whether each of the piece's clusters is turned, as the tree says. `must_close`: whether only sides are
  // taken whose normals add up to as little as those of a closed surface do (IsClosed,
  // core/normals/orientation/piece_sides.h): there are sides of any bowl whose winding number is nearly the same
  // everywhere. `field` outlives the repair.
  SideRepair(const FieldPiece& field, std::vector<uint8_t> turned, bool must_close);

  // With w for the winding number at a sampled point, 1 - mean(w)^2 / mean(w^2): free of the scale of areas, 0 where w
  // is the same everywhere, 1 where it has both signs alike. 2 if the mean is not positive. Of the sides of now.
  double certificate() const { return now_.fit.certificate; }
  // The mean of w: one half, up to how well the areas of points add up to that of the surface.
  double mean() const { return now_.fit.mean; }

  // Whether other sides might fit better: there are others, and these do not fit well.
  bool IsWanted() const;
  // Turns single clusters as long as that lessens the certificate, from the sides of now, of which some are turned at
  // random unless `start` is 0. Thread-safe for distinct starts. May throw std::bad_alloc.
  void Descend(size_t start);
  // Whether the best sides that were found fit much better than those of now, and may be right.
  bool IsPromising() const;
  // Takes the best sides if they are, and fit so well that chance does not explain it. Returns whether it does.
  bool Accept();
  // Whether Accept has taken other sides.
  bool is_accepted() const { return is_accepted_; }

  const std::vector<uint8_t>& turned() const { return now_.turned; }

 private:
  struct Fit {
    double certificate = 2.0;
    double mean = 0.0;
  };
  // Sides, the winding number at each sample that they make, and its sums.
  struct Trial {
    std::vector<uint8_t> turned;
    std::vector<float> winding;
    double sum = 0.0, squares = 0.0;
    Fit fit;
  };
  struct Sums {
    double sum, squares;  // over the samples, of what a cluster adds
  };
  Fit FitOf(double sum, double squares) const;
  void Measure(Trial& trial) const;
  bool TurnIfBetter(size_t cluster, Trial& trial) const;
  bool MayBeTaken(const Trial& trial) const;
  // Of those that may be taken; null if there are none.
  const Trial* BestTrial() const;

  const FieldPiece& field_;
  const bool must_close_;
  double weight_ = 0.0;     // of all samples
  std::vector<Sums> sums_;  // by cluster
  Trial now_;
  bool is_accepted_ = false;
  std::vector<Trial> trials_;
};

}  // namespace curvd
