// Component devices alone: prints the names of all devices.
#include <cstdio>

#include "devices/device_maker.h"

int main() {
  for (const auto& name : hapton::device_names()) std::printf("%s\n", std::string(name).c_str());
  return 0;
}
