#include "bench/paper/figure_flags.h"

#include <CLI/CLI.hpp>
#include <cstdlib>

namespace curvd::bench {

FigureFlags ParseFigureFlags(int argc, char** argv, const std::string& about, const std::string& quick) {
  FigureFlags flags;
  CLI::App app(about);
  app.add_flag("--tiny", flags.tiny, "Seconds: shows that it runs");
  app.add_flag("--quick", flags.quick, quick);
  app.add_option("--out", flags.out, "The CSV file")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return flags;
}

}  // namespace curvd::bench
