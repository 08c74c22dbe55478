// One comparison: several ways to do the same work, run in turns within one process by Google Benchmark.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace curvd::bench {

// Figures of one run by name; "total" (seconds) must be among them.
using Figures = std::map<std::string, double>;

// Not thread-safe; one at a time.
class SideBySide {
 public:
  explicit SideBySide(std::string name) : name_(std::move(name)) {}

  void Add(const std::string& way, std::function<Figures()> run);

  // Runs each way `rounds` times, the ways in random turns so that drift of the machine hits all alike, and prints
  // each. Returns the median of each figure by way.
  std::map<std::string, Figures> Run(int rounds);

 private:
  struct Way {
    std::string name;
    std::function<Figures()> run;
  };
  std::string name_;
  std::vector<Way> ways_;
};

}  // namespace curvd::bench
