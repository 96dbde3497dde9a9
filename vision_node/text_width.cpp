#include "vision_node/text_width.h"

#include <algorithm>
#include <array>
#include <string>

#include <vtkFreeTypeTools.h>
#include <vtkStdString.h>

namespace hapton {
namespace {

constexpr int kDotsPerInch = 72;  // the default of vtkWindow: a point is one pixel

}  // namespace

double measure_text_width_px(vtkTextProperty* look, std::string_view line) {
  if (line.empty()) return 0.0;
  std::array<int, 4> box = {};
  vtkFreeTypeTools::GetInstance()->GetBoundingBox(look, vtkStdString(std::string(line)), kDotsPerInch, box.data());
  return std::max(0, box[1] - box[0] + 1);
}

}  // namespace hapton
