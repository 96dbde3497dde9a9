#include "vision_node/window_picture.h"

#include <algorithm>

#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

namespace hapton {

Picture read_window_picture(vtkRenderWindow* window) {
  const int* pixels = window->GetSize();
  Picture picture;
  picture.size = {pixels[0], pixels[1]};
  vtkNew<vtkUnsignedCharArray> rgb;
  window->GetRGBACharPixelData(0, 0, pixels[0] - 1, pixels[1] - 1, 0, rgb);
  picture.rgb.resize(3 * static_cast<std::size_t>(pixels[0]) * pixels[1]);
  const std::uint8_t* rgba = rgb->GetPointer(0);
  for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) std::copy_n(rgba + 4 * i, 3, &picture.rgb[3 * i]);
  return picture;
}

bool write_window_png(vtkRenderWindow* window, const std::filesystem::path& file) {
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->SetInputBufferTypeToRGB();
  grab->ReadFrontBufferOff();
  grab->ShouldRerenderOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputConnection(grab->GetOutputPort());
  writer->Write();
  return writer->GetErrorCode() == 0;
}

}  // namespace hapton
