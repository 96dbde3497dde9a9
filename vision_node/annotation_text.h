#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scene/annotations.h"
#include "scene/scene_file.h"

namespace hapton {

// A count with its noun: "1 stroke", "2 strokes".
std::string plural(std::size_t count, std::string_view noun);

// The numbers of strokes and of measures: "2 strokes, 1 measure".
std::string describe_marks(const std::vector<Annotation>& entries);

// The same with the other content of a file: "2 strokes, 1 measure, 1 object put down, 300 carves".
std::string describe_entries(const Annotations& annotations);

// The names of the objects, in their order.
std::vector<std::string> list_names(const Scene& scene);

}  // namespace hapton
