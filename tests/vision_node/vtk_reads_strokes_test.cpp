// VTK reads exported strokes as they were drawn.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include "scene/annotations_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

TEST(VtkReadsStrokes, PointsCellsAndTheirData) {
  Annotations annotations;
  annotations.objects = {"a", "b"};
  annotations.entries = {Stroke{1, {{0.1, 0.2, 1.0 / 3.0}, {0.1, 0.25, 0.3}, {0.1, 0.3, 0.3}}}, Stroke{0, {{1, 2, 3}}},
                         Measure{{{{0, {0, 0, 0}}, {1, {0, 0, 0.5}}}}}};
  Pose X_SO = Pose::Identity();
  X_SO.translation() = Vec3(0, 0, 1);
  ScratchFolder scratch;
  const std::string file = scratch.write("a.vtp", write_annotations_vtp(annotations, {Pose::Identity(), X_SO}, 2)).string();
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  ASSERT_EQ(data->GetNumberOfPoints(), 6);
  ASSERT_EQ(data->GetNumberOfVerts(), 1);
  ASSERT_EQ(data->GetNumberOfLines(), 2);
  double p[3];
  data->GetPoint(0, p);
  EXPECT_EQ(Vec3(p[0], p[1], p[2]), Vec3(0.1, 0.2, 1.0 / 3.0 + 1.0));
  // VTK numbers the cells of single points first, then those of lines.
  const auto value = [&](const char* name, vtkIdType cell) { return data->GetCellData()->GetArray(name)->GetTuple1(cell); };
  EXPECT_EQ(data->GetCell(0)->GetNumberOfPoints(), 1);
  EXPECT_EQ(value("object", 0), 0);
  EXPECT_EQ(data->GetCell(1)->GetNumberOfPoints(), 3);
  EXPECT_EQ(value("kind", 1), 0);
  EXPECT_EQ(value("object", 1), 1);
  EXPECT_NEAR(value("length_m", 1), compute_length_m(std::get<Stroke>(annotations.entries[0])), 1e-15);
  EXPECT_EQ(data->GetCell(2)->GetNumberOfPoints(), 2);
  EXPECT_EQ(value("kind", 2), 1);
  EXPECT_EQ(value("length_m", 2), 1.5);  // object 1 is 1 m above object 0
}

}  // namespace
}  // namespace hapton
