#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/force/sphere/contact_set.h"
#include "core/force/sphere/gathered_triangles.h"
#include "tests/support/made_meshes.h"

namespace hapton {

// A small sphere in the lower corner of a box, or of other walls, with all three walls as active constraints. `others` are further meshes.
// Local units.
struct CornerStage {
  static constexpr Clearance kClearance{1e-5, 0x1p-40, 0x1p-46};

  // gather_radius: of the ball within which triangles are gathered. walls: three walls that meet at the origin.
  explicit CornerStage(double gather_radius, std::vector<const TriangleMesh*> others = {}, TriangleMesh walls = room())
      : box(std::move(walls)) {
    others.insert(others.begin(), &box);
    geometry = std::make_unique<TouchGeometry>(others);
    materials.resize(others.size());
    near = std::make_unique<GatheredTriangles>(*geometry, materials, kClearance, 64.0 * kClearance.offset);
    apex = geometry->to_local(Vec3::Zero());
    centre = apex + kClearance.offset * Vec3::Ones();
    near->widen(gather_radius);
    EXPECT_TRUE(near->gather(centre, Vec3::Zero(), work));
    for (const Vec3& normal : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) add_wall(normal);
    EXPECT_EQ(contacts.count(), 3);
    contacts.activate_all();
  }

  // A box whose sides have different lengths, so that the diagonals of its faces miss the contacts of the sphere.
  static TriangleMesh room() { return made::box(Vec3::Zero(), Vec3(1.0, 0.9, 0.8)); }
  // Three triangles that go through one another: at the point where all three meet, none has an edge or a vertex.
  static TriangleMesh crossing_walls() {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 u = Vec3::Unit((axis + 1) % 3), v = Vec3::Unit((axis + 2) % 3);
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), {-0.5 * u - 0.6 * v, 1.5 * u - 0.5 * v, -0.4 * u + 1.5 * v});
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
  }

  TriangleMesh box;
  std::unique_ptr<TouchGeometry> geometry;
  std::vector<Material> materials;
  std::unique_ptr<GatheredTriangles> near;
  ContactSet contacts{kClearance};
  Vec3 apex;
  Vec3 centre;
  int work = 0;

 private:
  void add_wall(const Vec3& normal) {
    bool is_added = false;
    near->visit_near(centre, centre, 1.5 * kClearance.offset, [&](int slot) {
      const OffsetContact contact = OffsetContact::nearest(near->triangle(slot), near->shape(slot), centre);
      const bool is_wall = contact.part == Feature::face && contact.normal.dot(normal) > 0.9;
      if (is_wall && !is_added) contacts.add(contact);
      is_added = is_added || is_wall;
    });
  }
};

}  // namespace hapton
