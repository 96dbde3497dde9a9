#pragma once

#include <string_view>

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Which vendors' libraries load, and why the others do not, with the loader's message. RT: no.
Findings check_libraries(const Machine& machine);

// Loads the library of that name in a child process, for Machine::Questions. Pre: the caller has no other threads.
LibraryReply try_vendor_library(std::string_view name);

}  // namespace hapton::doctor
