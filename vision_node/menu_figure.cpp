#include "vision_node/menu_figure.h"

#include <string>

#include <vtkAppendPolyData.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkMatrix4x4.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkVectorText.h>

#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

// Shares of an entry's height.
constexpr double kLetters = 0.5;
constexpr double kMargin = 0.6;
constexpr double kGap = 0.04;
// Height of the letters above the panel: enough for a depth buffer of 24 bits at any scale of the scene.
constexpr double kAbove = 0.1;

using Colour = std::array<unsigned char, 3>;
constexpr Colour kEntryColour = {38, 48, 62};
constexpr Colour kModeColour = {24, 92, 116};
constexpr Colour kLitColour = {235, 180, 40};

bool is_mode(TouchMenu::Entry entry, PenMode mode) {
  using Entry = TouchMenu::Entry;
  return (entry == Entry::off && mode == PenMode::off) || (entry == Entry::draw && mode == PenMode::draw) ||
         (entry == Entry::measure && mode == PenMode::measure);
}

vtkSmartPointer<vtkPolyData> make_labels() {
  vtkNew<vtkAppendPolyData> all;
  for (const TouchMenu::Entry entry : TouchMenu::kEntries) {
    vtkNew<vtkVectorText> letters;
    letters->SetText(std::string(TouchMenu::label(entry)).c_str());
    const double height = TouchMenu::kEntryHeightM;
    const Vec3 at =
        place_entry(entry) + Vec3(-0.5 * TouchMenu::kWidthM + kMargin * height, -0.5 * kLetters * 0.7 * height, kAbove * height);
    vtkNew<vtkTransform> move;
    move->Translate(at.data());
    move->Scale(kLetters * height, kLetters * height, kLetters * height);
    vtkNew<vtkTransformPolyDataFilter> placed;
    placed->SetTransform(move);
    placed->SetInputConnection(letters->GetOutputPort());
    placed->Update();
    all->AddInputData(placed->GetOutput());
  }
  all->Update();
  return all->GetOutput();
}

}  // namespace

MenuFigure::MenuFigure() {
  vtkNew<vtkPoints> corners;
  vtkNew<vtkCellArray> fields;
  for (const TouchMenu::Entry entry : TouchMenu::kEntries) {
    const Vec3 middle = place_entry(entry);
    const Vec3 half(0.5 * TouchMenu::kWidthM, (0.5 - kGap) * TouchMenu::kEntryHeightM, 0.0);
    vtkIdType ids[4];
    for (int k = 0; k < 4; ++k) {
      const Vec3 corner = middle + half.cwiseProduct(Vec3(k == 1 || k == 2 ? 1.0 : -1.0, k >= 2 ? 1.0 : -1.0, 0.0));
      ids[k] = corners->InsertNextPoint(corner.data());
    }
    fields->InsertNextCell(4, ids);
  }
  colours_->SetNumberOfComponents(3);
  colours_->SetNumberOfTuples(static_cast<vtkIdType>(TouchMenu::kEntries.size()));
  fields_->SetPoints(corners);
  fields_->SetPolys(fields);
  fields_->GetCellData()->SetScalars(colours_);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(fields_);
  mapper->SetScalarModeToUseCellData();
  panel_->SetMapper(mapper);
  vtkNew<vtkPolyDataMapper> label_mapper;
  label_mapper->SetInputData(make_labels());
  labels_->SetMapper(label_mapper);
  labels_->GetProperty()->SetColor(0.97, 0.98, 0.99);
  for (vtkActor* actor : {panel_.Get(), labels_.Get()}) {
    actor->GetProperty()->LightingOff();
    actor->VisibilityOff();
  }
}

void MenuFigure::add_to(vtkRenderer* renderer) {
  renderer->AddActor(panel_);
  renderer->AddActor(labels_);
}

void MenuFigure::set(const TouchMenu& menu, PenMode mode) {
  for (vtkActor* actor : {panel_.Get(), labels_.Get()}) actor->SetVisibility(menu.is_open());
  if (!menu.is_open()) return;
  vtkNew<vtkMatrix4x4> matrix;
  copy_matrix(menu.pose().matrix(), matrix);
  for (vtkActor* actor : {panel_.Get(), labels_.Get()}) actor->SetUserMatrix(matrix);
  for (std::size_t i = 0; i < TouchMenu::kEntries.size(); ++i) {
    const TouchMenu::Entry entry = TouchMenu::kEntries[i];
    const Colour& colour = menu.lit() == entry ? kLitColour : is_mode(entry, mode) ? kModeColour : kEntryColour;
    colours_->SetTypedTuple(static_cast<vtkIdType>(i), colour.data());
  }
  colours_->Modified();
}

}  // namespace hapton
