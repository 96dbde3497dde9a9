#pragma once

#include <filesystem>

#include "vision_node/stereo_view.h"

class vtkRenderWindow;

namespace hapton {

// What is in a window, as it was drawn last. RT: no. Threads: the window's.
Picture read_window_picture(vtkRenderWindow* window);

// Writes that as PNG. False: it could not be written.
bool write_window_png(vtkRenderWindow* window, const std::filesystem::path& file);

}  // namespace hapton
