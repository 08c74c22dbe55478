#include "bench/side_by_side.h"

#include <benchmark/benchmark.h>

#include "absl/strings/str_cat.h"
#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

// Prints as usual, and keeps each run's figures.
class KeepingReporter : public benchmark::ConsoleReporter {
 public:
  KeepingReporter() : ConsoleReporter(OO_None) {}

  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      for (const auto& [figure, counter] : run.counters) {
        runs_[run.run_name.function_name][figure].push_back(counter.value);
      }
    }
  }

  std::map<std::string, Figures> Medians() const {
    std::map<std::string, Figures> medians;
    for (const auto& [way, figures] : runs_) {
      for (const auto& [figure, values] : figures) medians[way][figure] = Median(values);
    }
    return medians;
  }

 private:
  std::map<std::string, std::map<std::string, std::vector<double>>> runs_;
};

void InitializeOnce() {
  static const bool done = [] {
    char program[] = "bench", interleave[] = "--benchmark_enable_random_interleaving=true";
    char* argv[] = {program, interleave, nullptr};
    int argc = 2;
    benchmark::Initialize(&argc, argv);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

void SideBySide::Add(const std::string& way, std::function<Figures()> run) { ways_.push_back({way, std::move(run)}); }

std::map<std::string, Figures> SideBySide::Run(int rounds) {
  InitializeOnce();
  for (const Way& way : ways_) {
    benchmark::RegisterBenchmark(way.name.c_str(),
                                 [&way](benchmark::State& state) {
                                   for (auto _ : state) {
                                     const Figures figures = way.run();
                                     state.SetIterationTime(figures.at("total"));
                                     for (const auto& [name, value] : figures) state.counters[name] = value;
                                   }
                                 })
        ->UseManualTime()
        ->Iterations(1)
        ->Repetitions(rounds);
  }
  KeepingReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter, ".*");
  benchmark::ClearRegisteredBenchmarks();
  auto medians = reporter.Medians();
  for (const Way& way : ways_) {
    std::printf("%s %s: %.4f s\n", name_.c_str(), way.name.c_str(), medians.at(way.name).at("total"));
  }
  std::fflush(stdout);
  return medians;
}

}  // namespace curvd::bench
