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
}

// The samples with the normals that are given to an estimate.
inline Samples WithNormals(Samples samples, const NormalFlags& flags, WorkerPool& pool) {
  if (flags.fitted_of == 0) return samples;
  return WithFittedNormals(samples, flags.fitted_by, flags.fitted_of, pool);
}

}  // namespace curvd::bench
