#include "runtime/build_id.h"

#include <fmt/core.h>

#include "runtime/report.h"

namespace hapton {

std::string hapton_version() { return HAPTON_VERSION; }

std::string build_id() {
  const MachineInfo machine = read_machine_info();
  return fmt::format("{}, {}, {}", HAPTON_VERSION, machine.compiler, machine.build);
}

}  // namespace hapton
