#include "vision_node/vtk_shapes.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyDataNormals.h>
#include <vtkShaderProperty.h>
#include <vtkSphereSource.h>

namespace hapton {

vtkSmartPointer<vtkPolyData> make_poly_data(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) points->SetPoint(static_cast<vtkIdType>(i), mesh.vertices[i].data());
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(mesh.triangles.size()), static_cast<vtkIdType>(3 * mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, ids);
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(cells);
  return data;
}

vtkSmartPointer<vtkPolyData> make_lathe(const std::vector<std::pair<double, double>>& profile) {
  constexpr int kSides = 28;               // of a round shape; a free choice
  constexpr double kCreaseDegrees = 35.0;  // edges that turn by more are drawn sharp; a free choice
  TriangleMesh mesh;
  for (const auto& [radius, height] : profile) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kSides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = ring * kSides + i;
      const std::uint32_t b = ring * kSides + (i + 1) % kSides;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
  }
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(make_poly_data(mesh));
  normals->SetFeatureAngle(kCreaseDegrees);
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

vtkSmartPointer<vtkPolyData> make_ball(double radius_m) {
  vtkNew<vtkSphereSource> ball;
  ball->SetRadius(radius_m);
  ball->SetThetaResolution(28);
  ball->SetPhiResolution(18);
  ball->Update();
  return ball->GetOutput();
}

void bring_to_front(vtkActor* actor, double share) {
  actor->GetShaderProperty()->AddVertexShaderReplacement(
      "//VTK::PositionVC::Impl", true,
      fmt::format("//VTK::PositionVC::Impl\n  gl_Position.z = {0:.6f} * gl_Position.z - {1:.6f} * gl_Position.w;\n", share, 1.0 - share),
      false);
}

void show_through(vtkActor* actor, double share) {
  bring_to_front(actor, share);
  actor->GetShaderProperty()->AddFragmentShaderReplacement(
      "//VTK::Light::Impl", true,
      "//VTK::Light::Impl\n"
      "  if (((int(gl_FragCoord.x) / 2 + int(gl_FragCoord.y) / 2) & 1) == 1) discard;\n",
      false);
}

void copy_matrix(const Mat4& from, vtkMatrix4x4* to) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) to->SetElement(row, column, from(row, column));
  }
}

}  // namespace hapton
