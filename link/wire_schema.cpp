#include "link/wire_schema.h"

#include <cstddef>

// Made by cmake/HaptonBytes.cmake from the output of protoc (proto/CMakeLists.txt).
extern "C" const unsigned char hapton_wire_schema[];
extern "C" const std::size_t hapton_wire_schema_size;

namespace hapton {

std::string_view wire_schema() noexcept { return {reinterpret_cast<const char*>(hapton_wire_schema), hapton_wire_schema_size}; }

}  // namespace hapton
