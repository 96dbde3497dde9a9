#pragma once

#include <string>

namespace hapton::standin {

// The path of a stand-in library; name: such as "openhaptics/libHD.so".
inline std::string library(const std::string& name) { return std::string(HAPTON_BIN_DIR) + "/../tests/standins/" + name; }

}  // namespace hapton::standin
