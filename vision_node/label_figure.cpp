#include "vision_node/label_figure.h"

#include <algorithm>

#include <vtkTextProperty.h>

namespace hapton {

void LabelFigure::add_to(vtkRenderer* renderer) {
  for (std::size_t i = 0; i < kMax; ++i) {
    auto text = vtkSmartPointer<vtkTextActor>::New();
    vtkTextProperty* style = text->GetTextProperty();
    style->SetFontFamilyToArial();
    style->SetColor(0.98, 0.98, 0.95);
    style->SetBackgroundColor(0.03, 0.04, 0.06);
    style->SetBackgroundOpacity(0.7);
    style->SetJustificationToCentered();
    style->SetVerticalJustificationToCentered();
    text->SetVisibility(false);
    renderer->AddActor2D(text);
    texts_.push_back(text);
  }
}

void LabelFigure::place(const std::vector<WorldLabel>& labels, const StereoScreen& screen, Eye eye, PictureSize size) {
  const int font = std::clamp(std::min(size.width_px / 48, size.height_px / 50), 9, 36);
  const EyeDepths depths = compute_eye_depths(screen, eye);
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    vtkTextActor* text = texts_[i];
    const bool shown = i < labels.size() && depths.eye_m - (screen.X_WV.inverse(Eigen::Isometry) * labels[i].p_W).z() > depths.near_m;
    text->SetVisibility(shown);
    if (!shown) continue;
    const Vec2 at = project_to_pixel(screen, eye, size, labels[i].p_W);
    text->SetPosition(at.x(), at.y());
    text->GetTextProperty()->SetFontSize(font);
    // A text is set only if it has changed: otherwise VTK would draw its letters again.
    if (text->GetInput() == nullptr || labels[i].text != text->GetInput()) text->SetInput(labels[i].text.c_str());
  }
}

}  // namespace hapton
