#pragma once

#include <string_view>

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks which vendors' libraries can be loaded, and why the others cannot, with the message of the loader. RT: no.
Findings check_libraries(const Machine& machine);

// Tries to load the library KnownVendorLibrary::name in a child process, for Machine::Queries. RT: no. Pre: this process has one thread.
LibraryReply try_vendor_library(std::string_view name);

}  // namespace hapton::doctor
