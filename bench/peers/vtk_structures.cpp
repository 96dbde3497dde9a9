#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>

#include <cmath>

#include "bench/peers/peer_structures.h"

namespace hapton {
namespace {

// first_hit(): IntersectWithLine with zero tolerance. nearest(): FindClosestPointWithinRadius. The points are stored in double.
template <class Locator>
class Vtk final : public QueryStructure {
 public:
  explicit Vtk(const TriangleMesh& mesh) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.vertices.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) points->SetPoint(static_cast<vtkIdType>(i), mesh.vertices[i].data());
    vtkNew<vtkCellArray> cells;
    for (const auto& [a, b, c] : mesh.triangles) cells->InsertNextCell({vtkIdType{a}, vtkIdType{b}, vtkIdType{c}});
    surface_->SetPoints(points);
    surface_->SetPolys(cells);
    locator_->SetDataSet(surface_);
    locator_->BuildLocator();
  }
  double first_hit(const Vec3& from, const Vec3& to) override {
    double t = 0.0;
    Vec3 at;
    Vec3 parametric;
    int part = 0;
    vtkIdType cell = -1;
    const int hit = locator_->IntersectWithLine(from.data(), to.data(), 0.0, t, at.data(), parametric.data(), part, cell, cell_);
    return hit != 0 ? t : kNothingFound;
  }
  double nearest(const Vec3& p, double radius) override {
    Vec3 at;
    vtkIdType cell = -1;
    int part = 0;
    double squared = 0.0;
    int inside = 0;
    Vec3 q = p;
    const vtkIdType found = locator_->FindClosestPointWithinRadius(q.data(), radius, at.data(), cell_, cell, part, squared, inside);
    return found != 0 && std::sqrt(squared) <= radius ? std::sqrt(squared) : kNothingFound;
  }

 private:
  vtkNew<vtkPolyData> surface_;
  vtkNew<Locator> locator_;
  vtkNew<vtkGenericCell> cell_;
};

template <class Locator>
Result<std::unique_ptr<QueryStructure>> make(const TriangleMesh& mesh) {
  return std::make_unique<Vtk<Locator>>(mesh);
}

}  // namespace

std::vector<QueryStructureKind> vtk_structures() {
  const std::string note = "IntersectWithLine, tolerance 0; FindClosestPointWithinRadius";
  return {{.library = {}, .name = "vtk static cell locator", .precision = "double", .note = note, .make = make<vtkStaticCellLocator>},
          {.library = {}, .name = "vtk cell locator", .precision = "double", .note = note, .make = make<vtkCellLocator>}};
}

}  // namespace hapton
