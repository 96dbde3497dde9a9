#pragma once

#include <string>

namespace hapton::standin {

// Where the stand-ins lie: "openhaptics/libHD.so".
inline std::string library(const std::string& name) { return std::string(HAPTON_BIN_DIR) + "/../tests/standins/" + name; }

}  // namespace hapton::standin
