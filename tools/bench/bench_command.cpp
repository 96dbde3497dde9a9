#include "tools/commands.h"

namespace hapton {

void add_bench_command(CommandLine app, int& exit_code) {
  const CommandLine bench =
      app.add_subcommand("bench", "Measure methods and structures beside other libraries; without a subcommand: numbers");
  bench.require_subcommands(0, 1);
  add_bench_effects_command(bench, exit_code);
  add_bench_sixdof_command(bench, exit_code);
  add_bench_haptons_command(bench, exit_code);
  add_bench_numbers_command(bench, exit_code);
  add_bench_objects_command(bench, exit_code);
  add_bench_papers_command(bench, exit_code);
  add_bench_pareto_command(bench, exit_code);
  add_bench_remote_command(bench, exit_code);
  add_bench_sculpt_command(bench, exit_code);
}

}  // namespace hapton
