#include "core/force/proxy/proxy_state.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(ProxyState, AProxyThatSettlesInFreeSpaceTouchesNothing) {
  ProxyState proxy;
  proxy.is_free = false;
  proxy.slides = true;
  proxy.contact_count = 2;
  proxy.active_count = 1;
  EXPECT_EQ(proxy.active().size(), 1U);
  proxy.settle_at(Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(proxy.position, Vec3(1.0, 2.0, 3.0));
  EXPECT_TRUE(proxy.is_free);
  EXPECT_FALSE(proxy.slides);
  EXPECT_EQ(proxy.contact_count, 0);
  EXPECT_TRUE(proxy.active().empty());
}

class ProxySurfacesTest : public testing::Test {
 protected:
  TriangleMesh box_ = make_box(Vec3::Constant(0.1));
  TriangleMesh other_ = scaled_and_moved(make_box(Vec3::Constant(0.1)), 1.0, Vec3(0.2, 0.0, 0.0));
  TouchGeometry geometry_{std::vector<const TriangleMesh*>{&box_, &other_}};
  std::uint32_t first_of_other_ = static_cast<std::uint32_t>(geometry_.object_bits() & -geometry_.object_bits());
};

TEST_F(ProxySurfacesTest, AOneSidedTriangleIsTouchedFromTheFrontOnly) {
  const std::vector<Material> materials = {{.two_sided = false}, {}};
  const ProxySurfaces surfaces(geometry_, materials);
  const ContactTriangle shape = surfaces.shape_of(0);
  const Vec3 middle = (shape.corner(0) + shape.corner(1) + shape.corner(2)) / 3.0;
  EXPECT_TRUE(surfaces.can_touch(0, middle + 0.01 * shape.normal()));
  EXPECT_FALSE(surfaces.can_touch(0, middle - 0.01 * shape.normal()));
  const ContactTriangle other = surfaces.shape_of(first_of_other_);
  EXPECT_TRUE(surfaces.can_touch(first_of_other_, other.corner(0) - 0.01 * other.normal()));
}

TEST_F(ProxySurfacesTest, TheMeanMaterialWeighsActiveConstraints) {
  const std::vector<Material> materials = {{.stiffness_n_per_m = 1000.0}, {.stiffness_n_per_m = 3000.0, .friction_static = 0.1}};
  const ProxySurfaces surfaces(geometry_, materials);
  EXPECT_TRUE(surfaces.has_friction());
  ProxyState proxy;
  EXPECT_EQ(surfaces.mean_material(proxy).stiffness_n_per_m, 1000.0);
  proxy.contacts[0].triangle = 0;
  proxy.contacts[1].triangle = first_of_other_;
  proxy.contact_count = 2;
  proxy.active_count = 2;
  proxy.multipliers = {1.0, 3.0, 0.0};
  EXPECT_DOUBLE_EQ(surfaces.mean_material(proxy).stiffness_n_per_m, 2500.0);
}

}  // namespace
}  // namespace hapton
