#include <cstdio>

#include "runtime/descriptor_check.h"
#include "runtime/instruction_set_check.h"
#include "runtime/standard_streams.h"
#include "tools/hapton_command.h"

int main(int argc, char** argv) {
  hapton::open_standard_streams();
  hapton::check_cpu("hapton");
  hapton::check_descriptors("hapton");
  const int exit_code = hapton::run_hapton_command(argc, argv);
  const auto printed = hapton::flush_standard_output();
  if (printed) return exit_code;
  std::fprintf(stderr, "hapton: %s\n", printed.error().what.c_str());
  return exit_code != 0 ? exit_code : 1;
}
