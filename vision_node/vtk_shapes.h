#pragma once

#include <utility>
#include <vector>

#include <vtkActor.h>
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

// Share of the depth range, at its front, for what shows through the scene.
constexpr double kGhostShare = 1e-3;
// Moves the drawing to the front part of the depth range, in its own order.
void bring_to_front(vtkActor* actor, double share);
// The same, with every other 2 x 2 block of pixels left out: blocks, because some stereo modes use patterns of single pixels.
void show_through(vtkActor* actor, double share = kGhostShare);

void copy_matrix(const Mat4& from, vtkMatrix4x4* to);

}  // namespace hapton
