#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench papers: what the HP memo and the FDH paper say of their own systems, measured again on this machine. Exit code 0 only when
// every row asked for was measured.
void add_bench_papers_command(CommandLine bench, int& exit_code);

}  // namespace hapton
