#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkActor2DCollection.h>
#include <vtkActorCollection.h>
#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkUnsignedCharArray.h>

#include "core/math/types.h"

namespace hapton {

using PartColour = std::array<int, 3>;

// What a figure gives to VTK, read as numbers: its texts, its other 2D actors (flat) and its 3D actors (solid). No window is needed.
struct FigureParts {
  template <class Figure>
  explicit FigureParts(Figure& figure) {
    figure.add_to(renderer);
    for (int i = 0; i < renderer->GetActors2D()->GetNumberOfItems(); ++i) {
      auto* actor = vtkActor2D::SafeDownCast(renderer->GetActors2D()->GetItemAsObject(i));
      auto* text = vtkTextActor::SafeDownCast(actor);
      (text != nullptr ? texts_ : flat_).push_back(actor);
    }
    vtkActorCollection* actors = renderer->GetActors();  // GetActors() makes a new list at each call
    actors->InitTraversal();
    while (vtkActor* actor = actors->GetNextActor()) solid_.push_back(actor);
  }

  vtkTextActor* text(std::size_t i) const { return vtkTextActor::SafeDownCast(texts_.at(i)); }
  // The visible text actor that has this text; null if there is none.
  vtkTextActor* find_text(std::string_view content) const {
    for (vtkActor2D* actor : texts_) {
      auto* text = vtkTextActor::SafeDownCast(actor);
      if (text->GetVisibility() != 0 && text->GetInput() != nullptr && content == text->GetInput()) return text;
    }
    return nullptr;
  }
  std::size_t texts() const { return texts_.size(); }
  vtkActor2D* flat(std::size_t i) const { return flat_.at(i); }
  vtkPolyData* flat_shape(std::size_t i) const { return vtkPolyDataMapper2D::SafeDownCast(flat_.at(i)->GetMapper())->GetInput(); }
  vtkActor* solid(std::size_t i) const { return solid_.at(i); }
  vtkPolyData* solid_shape(std::size_t i) const { return vtkPolyDataMapper::SafeDownCast(solid_.at(i)->GetMapper())->GetInput(); }
  bool is_any_shown() const {
    for (const auto* list : {&texts_, &flat_}) {
      for (vtkActor2D* actor : *list) {
        if (actor->GetVisibility() != 0) return true;
      }
    }
    for (vtkActor* actor : solid_) {
      if (actor->GetVisibility() != 0) return true;
    }
    return false;
  }

  vtkNew<vtkRenderer> renderer;

 private:
  std::vector<vtkActor2D*> texts_;
  std::vector<vtkActor2D*> flat_;
  std::vector<vtkActor*> solid_;
};

inline Vec3 point_of(vtkPolyData* shape, vtkIdType i) {
  std::array<double, 3> p = {};
  shape->GetPoint(i, p.data());
  return {p[0], p[1], p[2]};
}

inline PartColour colour_of(vtkDataArray* colours, vtkIdType i) {
  return {static_cast<int>(colours->GetComponent(i, 0)), static_cast<int>(colours->GetComponent(i, 1)),
          static_cast<int>(colours->GetComponent(i, 2))};
}

// The points of each cell, in the order of the cells.
inline std::vector<std::vector<vtkIdType>> cells_of(vtkCellArray* cells) {
  std::vector<std::vector<vtkIdType>> all;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < cells->GetNumberOfCells(); ++c) {
    cells->GetCellAtId(c, ids);
    all.emplace_back(ids->begin(), ids->end());
  }
  return all;
}

inline Eigen::Vector2d place_of(vtkTextActor* text) {
  const double* at = text->GetPosition();
  return {at[0], at[1]};
}

}  // namespace hapton
