#pragma once

#include <span>
#include <string>

#include "scene/object_names.h"

namespace hapton {

// "name,material" of the object of that number, each in quotes where CSV needs them; "," where there is none. RT: no.
std::string csv_names(std::span<const ObjectName> names, int object);

// Any text as one cell.
std::string csv_cell(const std::string& text);

}  // namespace hapton
