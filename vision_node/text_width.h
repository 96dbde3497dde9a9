#pragma once

#include <string_view>

#include <vtkTextProperty.h>

namespace hapton {

// The width of a line of text in pixels when VTK draws it with these text properties. RT: no.
double measure_text_width_px(vtkTextProperty* look, std::string_view line);

}  // namespace hapton
