// Says which response of an EstimateCurvature call comes next; a state machine that knows neither socket nor message.
#pragma once

#include <cstdint>

namespace curvd {

// Tells which message comes next, given what has happened: one Accepted; then any number of Progress; then, when the
// cloud is estimated, ResultChunks that cover it in ascending order without gaps, and one Summary; then the end.
// A chunk of results is handed out when it is asked for, and not before. Not thread-safe.
class ResponseSession {
 public:
  enum class Kind { kNothing, kAccepted, kProgress, kResults, kSummary, kEnd };
  struct Message {
    Kind kind = Kind::kNothing;
    // Of kResults: points [first, first + count), count > 0, at this scale.
    uint64_t first = 0;
    uint64_t count = 0;
    uint64_t scale = 0;
  };

  // The header is right: Accepted is due. REQUIRES: called once.
  void Accept();
  // Whether a Progress is due, until the next call of this. Has an effect between Accept and Complete only.
  void SetProgressDue(bool is_due);
  // All of the cloud's points are estimated: its results are due, `chunk_points` in each ResultChunk, the last one
  // perhaps fewer, those of one scale after those of the other; then the summary. REQUIRES: Accept was called; called
  // once; chunk_points > 0.
  void Complete(uint64_t points, uint64_t chunk_points, uint64_t scales = 1);

  // The message that is to be written now, if any. It counts as written: each is handed out once. After kEnd, which
  // says that all were handed out, it is kEnd for ever.
  Message Next();

 private:
  uint64_t chunk_points_ = 1;
  bool is_accepted_ = false;
  bool accepted_due_ = false;
  bool progress_due_ = false;
  bool is_complete_ = false;
  bool summary_due_ = false;
  uint64_t points_ = 0;
  uint64_t next_point_ = 0;
  uint64_t scales_ = 1;
  uint64_t next_scale_ = 0;
};

}  // namespace curvd
