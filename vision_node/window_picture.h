#pragma once

#include <filesystem>

#include "vision_node/stereo_view.h"

class vtkRenderWindow;

namespace hapton {

// Reads the pixels of a window as they were drawn last. RT: no. Threads: the window's.
Picture read_window_picture(vtkRenderWindow* window);

// Writes these pixels to a PNG file. False: it could not be written.
bool write_window_png(vtkRenderWindow* window, const std::filesystem::path& file);

}  // namespace hapton
