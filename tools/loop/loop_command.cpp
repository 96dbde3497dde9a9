#include "tools/commands.h"

namespace hapton {

void add_loop_command(CommandLine app, int& exit_code) {
  const CommandLine command =
      app.add_subcommand("loop", "Stable and passive stiffness of hand, device and force program in closed loop");
  command.require_subcommands(1, 1);
  add_loop_zwidth_command(command, exit_code);
  add_loop_press_command(command, exit_code);
  add_loop_recommend_command(command, exit_code);
  add_loop_integrators_command(command, exit_code);
  add_loop_velocity_command(command, exit_code);
  add_loop_merge_command(command, exit_code);
}

}  // namespace hapton
