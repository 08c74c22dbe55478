#include "bench/flags.h"

#include <CLI/CLI.hpp>
#include <cstdlib>

namespace curvd::bench {

Flags ParseFlags(int argc, char** argv, const std::string& description) {
  Flags flags;
  flags.clouds = BENCH_CLOUD_DIR;
  CLI::App app(description);
  app.add_flag("--quick", flags.quick, "Small clouds and few rounds");
  app.add_flag("--full", flags.full, "Also the clouds that take minutes");
  app.add_option("--rounds", flags.rounds, "Repetitions of each measurement")->check(CLI::PositiveNumber);
  app.add_option("--out", flags.out, "Folder for a CSV file of each table")->check(CLI::ExistingDirectory);
  app.add_option("--clouds", flags.clouds, "Folder that keeps generated clouds")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return flags;
}

}  // namespace curvd::bench
