// The flags that say where the normals of samples come from.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "bench/paper/samples.h"

namespace curvd::bench {

struct NormalFlags {
  bool makes = false;      // curvd makes them
  uint32_t fitted_of = 0;  // neighbors of which they are made before they are given; 0: they are the samples' own
  NormalMethod fitted_by = NormalMethod::kPca;
  size_t scans = 1;          // that the samples belong to in turn, while normals are made of neighbors
  size_t smoothed_over = 1;  // nearest samples, whose normals are averaged in the end
};

// REQUIRES: `flags` outlives the parse.
inline void AddNormalFlags(CLI::App& app, NormalFlags& flags) {
  std::map<std::string, NormalMethod> methods;
  for (const NormalMethod method :
       {NormalMethod::kPca, NormalMethod::kJet1, NormalMethod::kJet2, NormalMethod::kJet4}) {
    methods.emplace(NormalMethodName(method), method);
  }
  CLI::Option* const makes =
      app.add_flag("--make-normals", flags.makes, "Normals are made of the positions, in place of the samples' own");
  CLI::Option* const fitted =
      app.add_option("--fitted-normals", flags.fitted_of,
                     "Normals are given, but made of so many neighbors each, as by other programs; 0: the samples' own")
          ->excludes(makes);
  app.add_option("--normal-fit", flags.fitted_by, "By which fit they are made: pca, jet-1, jet-2 or jet-4")
      ->transform(CLI::CheckedTransformer(std::move(methods)))
      ->needs(fitted);
  app.add_option("--scans", flags.scans, "Scans that the samples belong to in turn: neighbors are of the same one")
      ->check(CLI::Range(1, 16))
      ->needs(fitted);
  app.add_option("--smoothed-over", flags.smoothed_over,
                 "Normals that are given are then averaged over so many nearest samples")
      ->check(CLI::Range(1, 1000))
      ->excludes(makes);
}

// The samples with the normals that are given to an estimate.
inline Samples WithNormals(Samples samples, const NormalFlags& flags, WorkerPool& pool) {
  if (flags.fitted_of > 0) {
    samples = WithFittedNormals(samples, flags.fitted_by, flags.fitted_of, flags.scans, pool);
  }
  return flags.smoothed_over > 1 ? WithSmoothedNormals(samples, flags.smoothed_over) : samples;
}

}  // namespace curvd::bench
