// Flags that all benchmark programs share.
#pragma once

#include <string>

namespace curvd::bench {

struct Flags {
  bool quick = false;  // small clouds, few rounds: shows that it runs, not how fast
  bool full = false;   // also the clouds that take minutes
  int rounds = 0;      // repetitions of each measurement; 0: the program's own number
  std::string out;     // folder that gets a CSV file for each table; "": none
  std::string clouds;  // folder that keeps generated clouds between runs

  // `usual` rounds, unless told otherwise.
  int RoundsOr(int usual) const { return rounds > 0 ? rounds : quick ? 2 : usual; }
};

// Ends the program on --help and on what it does not understand.
Flags ParseFlags(int argc, char** argv, const std::string& description);

}  // namespace curvd::bench
