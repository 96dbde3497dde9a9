#include "vision_node/window_picture.h"

#include <algorithm>

#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

namespace hapton {

Picture read_window_picture(vtkRenderWindow* window) {
  const int* size = window->GetSize();
  Picture picture;
  picture.size = {size[0], size[1]};
  vtkNew<vtkUnsignedCharArray> rgba;
  window->GetRGBACharPixelData(0, 0, size[0] - 1, size[1] - 1, 0, rgba);
  picture.rgb.resize(3 * static_cast<std::size_t>(size[0]) * size[1]);
  const std::uint8_t* first_byte = rgba->GetPointer(0);
  for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) std::copy_n(first_byte + 4 * i, 3, &picture.rgb[3 * i]);
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
