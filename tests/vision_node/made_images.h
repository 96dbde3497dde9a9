#pragma once

#include <string>

#include <vtkImageData.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include "core/math/types.h"

namespace hapton {

// An image file of this size, in memory. colour_at counts pixels from the upper left corner; its colours are 0 to 255.
template <class Writer, class ColourAt>
std::string make_image(int width, int height, ColourAt colour_at) {
  vtkNew<vtkImageData> data;
  data->SetDimensions(width, height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3i colour = colour_at(x, y);
      for (int k = 0; k < 3; ++k) data->SetScalarComponentFromDouble(x, height - 1 - y, 0, k, colour[k]);
    }
  }
  vtkNew<Writer> writer;
  writer->SetInputData(data);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  return {reinterpret_cast<const char*>(bytes->GetPointer(0)), static_cast<std::size_t>(bytes->GetNumberOfValues())};
}

// Like make_image, but a PNG with alpha: colour_at returns four numbers.
template <class ColourAt>
std::string make_rgba_png(int width, int height, ColourAt colour_at) {
  vtkNew<vtkImageData> data;
  data->SetDimensions(width, height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector4i colour = colour_at(x, y);
      for (int k = 0; k < 4; ++k) data->SetScalarComponentFromDouble(x, height - 1 - y, 0, k, colour[k]);
    }
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(data);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  return {reinterpret_cast<const char*>(bytes->GetPointer(0)), static_cast<std::size_t>(bytes->GetNumberOfValues())};
}

// A square PNG with sides of this many pixels. Its quarters are red and green (upper), blue and white (lower).
inline std::string make_quarters_png(int side_px) {
  return make_image<vtkPNGWriter>(side_px, side_px, [side_px](int x, int y) {
    const bool right = 2 * x >= side_px;
    const bool low = 2 * y >= side_px;
    return low ? (right ? Eigen::Vector3i(255, 255, 255) : Eigen::Vector3i(0, 0, 255))
               : (right ? Eigen::Vector3i(0, 255, 0) : Eigen::Vector3i(255, 0, 0));
  });
}

}  // namespace hapton
