#include "vision_node/hud_figure.h"

#include <algorithm>
#include <string>

#include <vtkTextProperty.h>

namespace hapton {
namespace {

// A text that did not change is not set: VTK would draw its letters again.
void set_text(vtkTextActor* actor, std::string_view text) {
  const std::string owned(text);
  actor->SetVisibility(!owned.empty());
  if (!owned.empty() && (actor->GetInput() == nullptr || owned != actor->GetInput())) actor->SetInput(owned.c_str());
}

}  // namespace

void HudFigure::add_to(vtkRenderer* renderer) {
  for (vtkTextActor* text : {facts_.Get(), help_.Get()}) {
    vtkTextProperty* look = text->GetTextProperty();
    look->SetFontFamilyToArial();
    look->SetColor(0.96, 0.97, 0.98);
    look->SetBackgroundColor(0.03, 0.04, 0.06);
    look->SetBackgroundOpacity(0.45);
    look->SetLineSpacing(1.15);
    text->SetVisibility(false);
    renderer->AddActor2D(text);
  }
  facts_->GetTextProperty()->SetVerticalJustificationToTop();
}

void HudFigure::place(PictureSize size) {
  const int font = std::clamp(std::min(size.width_px / 44, size.height_px / 46), 9, 40);
  const int edge = font / 2;
  facts_->GetTextProperty()->SetFontSize(font);
  help_->GetTextProperty()->SetFontSize(std::max(9, font - 2));
  facts_->SetPosition(edge, size.height_px - edge);
  help_->SetPosition(edge, edge);
}

void HudFigure::set(std::string_view facts, std::string_view help) {
  set_text(facts_, facts);
  set_text(help_, help);
}

}  // namespace hapton
