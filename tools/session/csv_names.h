#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/object_names.h"

namespace hapton {

// "name,material" of the object of that number, each in quotes where CSV needs them; "," where there is none. RT: no.
std::string csv_names(std::span<const ObjectName> names, int object);

// All of a text, however long, with "?" for what is not printable: as every export writes names, paths and methods.
std::string whole_text(std::string_view text);

// Any text as one cell.
std::string csv_cell(const std::string& text);

}  // namespace hapton
