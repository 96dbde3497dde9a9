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

// The surface that a profile of (radius, height) points, bottom to top, makes when it turns about the z axis. Zero radii close it.
vtkSmartPointer<vtkPolyData> make_lathe(const std::vector<std::pair<double, double>>& profile);

vtkSmartPointer<vtkPolyData> make_ball(double radius_m);

// Share of the depth range, at its near end, for what is drawn through the scene.
constexpr double kGhostShare = 1e-3;
// Draws the actor in this share of the depth range, at its near end, so that it covers the scene; its parts still hide each other.
void bring_to_front(vtkActor* actor, double share);
// Like bring_to_front(), but leaves out every other block of 2 x 2 pixels: blocks, because some stereo modes use patterns of single pixels.
void show_through(vtkActor* actor, double share = kGhostShare);

void copy_matrix(const Mat4& from, vtkMatrix4x4* to);

}  // namespace hapton
