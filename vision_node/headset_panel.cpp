#include "vision_node/headset_panel.h"

#include <string>

#include <vtkTextProperty.h>

#include "core/math/types.h"

namespace hapton {
namespace {

constexpr int kFontPx = 40;  // of the letters' image, whatever their size in the world
// 6 mm are half a degree at 0.65 m, where the workspace is by default.
constexpr double kLineM = 0.006;
constexpr double kNoticeM = 0.012;
// The workspace of the memo is 0.267 x 0.19 x 0.381 m (docs/frames.md); scenes stay below its upper edge.
const Vec3 kFactsAt(-0.19, 0.11, -0.19);
const Vec3 kHelpAt(0.02, 0.11, -0.19);
const Vec3 kNoticeAt(0.0, 0.16, -0.10);

void place(vtkTextActor3D* text, const Vec3& p_W, double line_m) {
  const double scale = line_m / kFontPx;
  text->SetScale(scale, scale, scale);
  text->SetPosition(p_W.x(), p_W.y(), p_W.z());
  vtkTextProperty* look = text->GetTextProperty();
  look->SetFontFamilyToArial();
  look->SetFontSize(kFontPx);
  look->SetColor(0.96, 0.97, 0.98);
  look->SetBackgroundColor(0.03, 0.04, 0.06);
  look->SetBackgroundOpacity(0.8);
  text->VisibilityOff();
}

// A text that did not change is not set: VTK would draw its letters again.
void show(vtkTextActor3D* actor, std::string_view text) {
  const std::string owned(text);
  actor->SetVisibility(!owned.empty());
  if (!owned.empty() && (actor->GetInput() == nullptr || owned != actor->GetInput())) actor->SetInput(owned.c_str());
}

}  // namespace

HeadsetPanel::HeadsetPanel() {
  place(facts_, kFactsAt, kLineM);
  place(help_, kHelpAt, kLineM);
  place(notice_, kNoticeAt, kNoticeM);
  notice_->GetTextProperty()->SetColor(1.0, 0.78, 0.10);
  notice_->GetTextProperty()->SetJustificationToCentered();
}

void HeadsetPanel::add_to(vtkRenderer* renderer) {
  for (vtkTextActor3D* text : {facts_.Get(), help_.Get(), notice_.Get()}) renderer->AddActor(text);
}

void HeadsetPanel::set(std::string_view facts, std::string_view help, std::string_view notice) {
  show(facts_, facts);
  show(help_, help);
  show(notice_, notice);
}

}  // namespace hapton
