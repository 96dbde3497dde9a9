#pragma once

#include <memory>

#include "scene/object_reader.h"
#include "scene/scene_file.h"
#include "tests/support/made_meshes.h"

// Scenes with one body on a table; y is up.
namespace hapton::dynamics {

constexpr int kTable = 0;
constexpr int kBox = 1;
constexpr double kBoxKg = 0.2;
constexpr double kBoxSideM = 0.04;

inline std::shared_ptr<const TriangleMesh> moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) vertex += by;
  return made::shared(std::move(mesh));
}

inline SceneObject make_object(const char* name, std::shared_ptr<const TriangleMesh> mesh) {
  SceneObject object;
  object.name = name;
  object.mesh = std::move(mesh);
  return object;
}

// Makes the object movable by a program. pivot: relative to the centre of its bounding box.
inline void make_commanded(SceneObject& object, const Vec3& pivot = Vec3::Zero()) {
  ObjectSpec spec;
  spec.motion.by_program = true;
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : object.mesh->vertices) box.extend(vertex);
  spec.motion.p_MP = box.center() + pivot;
  object.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *object.mesh);
}

struct TableSetting {
  double height_m = 0.0;  // of the box above the table
  int table_cells = 0;    // above 0: the table is a sheet of so many cells a side
  double mass_kg = kBoxKg;
  double stiffness_n_per_m = 1000.0;
};

inline Scene table_scene(const TableSetting& setting = {}) {
  Scene scene;
  scene.given_hash = 7;
  TriangleMesh table = made::box({-0.2, -0.02, -0.2}, {0.2, 0, 0.2});
  if (setting.table_cells > 0) {
    table = made::sheet(0.2, 0.0, setting.table_cells);
    for (Vec3& vertex : table.vertices) vertex = Vec3(vertex.x(), vertex.z(), -vertex.y());
  }
  scene.objects.push_back(make_object("table", made::shared(std::move(table))));
  const double half = kBoxSideM / 2;
  SceneObject box = make_object("box", moved(made::box({-half, 0, -half}, {half, kBoxSideM, half}), {0, setting.height_m, 0}));
  box.material.stiffness_n_per_m = setting.stiffness_n_per_m;
  box.mass_kg = setting.mass_kg;
  make_commanded(box);
  scene.objects.push_back(std::move(box));
  return scene;
}

// A square tube whose wall lies between the half widths `inner` and `outer`, from y = 0 up.
inline TriangleMesh frame(double inner, double outer, double height) {
  TriangleMesh mesh;
  for (const double y : {0.0, height}) {
    for (const double half : {inner, outer}) {
      for (const auto& [x, z] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) mesh.vertices.emplace_back(half * x, y, half * z);
    }
  }
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  // Corners: inner below 0-3, outer below 4-7, inner above 8-11, outer above 12-15.
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    quad(4 + i, 4 + j, j, i);            // below
    quad(8 + i, 8 + j, 12 + j, 12 + i);  // above
    quad(j, j + 8, i + 8, i);            // inner wall
    quad(4 + i, 12 + i, 12 + j, 4 + j);  // outer wall
  }
  return mesh;
}

constexpr double kFrameGapM = 0.01;  // between the frame and the post in it

inline Scene frame_around_post_scene() {
  Scene scene = table_scene();
  scene.objects[kBox].mesh = made::shared(frame(0.02, 0.04, 0.02));
  make_commanded(scene.objects[kBox]);
  const double half = 0.02 - kFrameGapM;
  scene.objects.push_back(make_object("post", made::shared(made::box({-half, 0, -half}, {half, 0.05, half}))));
  return scene;
}

}  // namespace hapton::dynamics
