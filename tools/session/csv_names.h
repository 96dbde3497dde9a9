#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/object_names.h"

namespace hapton {

// "name,material" of the object with that number, each in quotes where CSV needs them; "," if it is not among the names. RT: no.
std::string csv_names(std::span<const ObjectName> names, int object);

// The whole text, however long, with "?" for each character that is not printable: for names, paths and methods in exports.
std::string whole_text(std::string_view text);

// The text as one cell of a CSV file: in quotes where CSV needs them.
std::string csv_cell(const std::string& text);

}  // namespace hapton
