#include "runtime/cpu_check.h"
#include "runtime/descriptor_check.h"
#include "tools/hapton_command.h"

int main(int argc, char** argv) {
  hapton::check_cpu("hapton");
  hapton::check_descriptors("hapton");
  return hapton::run_hapton_command(argc, argv);
}
