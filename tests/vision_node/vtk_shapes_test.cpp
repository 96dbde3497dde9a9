#include "vision_node/vtk_shapes.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(VtkShapes, MeshKeepsItsVerticesAndTriangles) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto data = make_poly_data(mesh);
  EXPECT_EQ(data->GetNumberOfPoints(), 4);
  EXPECT_EQ(data->GetNumberOfPolys(), 2);
  double bounds[6];
  data->GetBounds(bounds);
  EXPECT_EQ(bounds[1], 1.0);
  EXPECT_EQ(bounds[3], 2.0);
  EXPECT_EQ(bounds[5], 3.0);
}

TEST(VtkShapes, LatheReachesItsProfile) {
  const auto cone = make_lathe({{0.0, 0.0}, {0.5, 2.0}, {0.0, 2.0}});
  double bounds[6];
  cone->GetBounds(bounds);
  EXPECT_NEAR(bounds[1], 0.5, 1e-6);
  EXPECT_NEAR(bounds[4], 0.0, 1e-6);
  EXPECT_NEAR(bounds[5], 2.0, 1e-6);
  EXPECT_GT(cone->GetNumberOfPolys(), 0);
}

TEST(VtkShapes, MatrixIsCopiedRowByRow) {
  Mat4 from;
  for (int i = 0; i < 16; ++i) from(i / 4, i % 4) = i;
  vtkSmartPointer<vtkMatrix4x4> to = vtkSmartPointer<vtkMatrix4x4>::New();
  copy_matrix(from, to);
  EXPECT_EQ(to->GetElement(1, 2), 6.0);
  EXPECT_EQ(to->GetElement(3, 0), 12.0);
}

}  // namespace
}  // namespace hapton
