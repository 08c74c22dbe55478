// What the judges of all quantities say of the candidates, over the whole cloud and at each sampled point.
#pragma once

#include <cstddef>
#include <vector>

#include "core/scale/of_quantities.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// What one quantity says of every candidate that may count.
struct Judged {
  std::vector<ScaleScore> scores;
  std::vector<std::vector<double>> differences;  // of each candidate, at each sampled point
  std::vector<LocalTrend> trends;                // of each candidate
  std::vector<std::vector<double>> errors;       // of each candidate, at each sampled point: what weights are made of
  std::vector<std::vector<double>> weights;      // of each candidate, at each sampled point; 1 in all at a point
  std::vector<double> shares;                    // of each candidate: its mean weight over the sampled points
};

// What all quantities say, of the same candidates in one order.
struct AllJudged {
  std::vector<ScaleScore> scores;  // of the mean curvature, of all candidates; empty: none can be judged
  OfQuantities<Judged> of;         // of those that may count
  double sigma;                    // noise of the positions
};

// Jets of degree 6 are dropped unless they are expected to err less than all others times `worthwhile`. Thread-safe.
AllJudged JudgeAll(PilotPoints table, const ScaleBounds& bounds, double worthwhile);

// What JudgeAll, and ChooseScales with it, hold of each point of the table while they run, at most.
size_t JudgingBytesPerSample();

}  // namespace curvd
