#pragma once

#include <utility>
#include <vector>

#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "core/geometry/triangle_mesh.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

vtkSmartPointer<vtkPolyData> make_poly_data(const TriangleMesh& mesh);

// A profile of (radius, height) points, bottom to top, turned about the z axis. Zero radii close it.
vtkSmartPointer<vtkPolyData> make_lathe(const std::vector<std::pair<double, double>>& profile);

vtkSmartPointer<vtkPolyData> make_ball(double radius_m);

void copy_matrix(const Mat4& from, vtkMatrix4x4* to);

}  // namespace hapton
