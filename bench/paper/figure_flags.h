// The flags of programs that measure what figures are drawn from.
#pragma once

#include <string>

namespace curvd::bench {

struct FigureFlags {
  bool tiny = false;   // --tiny: seconds, to show that it runs
  bool quick = false;  // --quick: less of everything
  std::string out;     // --out: the CSV file to write
};

// Reads the flags of a program that `about` tells of, whose --quick does what `quick` says. Ends the program on wrong
// ones, naming them, and after --help.
FigureFlags ParseFigureFlags(int argc, char** argv, const std::string& about, const std::string& quick);

}  // namespace curvd::bench
