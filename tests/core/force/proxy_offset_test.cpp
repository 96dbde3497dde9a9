#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/force/force_method.h"
#include "core/force/proxy_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// A probe with a radius that is pressed along a path over a bumpy sphere.
TEST(ProxyOffset, IsTheReferenceOverABumpySphere) {
  constexpr int kSteps = 300;
  const TouchScene scene{.objects = {{made::shared(made::sphere(0.05, 12, 0.05)), {}}}};
  const auto proxy = make_method({.name = "proxy", .probe_radius_m = 0.004}, scene).value();
  const auto reference = make_method({.name = "reference", .probe_radius_m = 0.004}, scene).value();
  const auto device = [](int i) {
    const double polar = 0.9 + 0.0021 * i;
    const double azimuth = 0.3 + 0.0037 * i;
    const double radius = 0.055 - 0.004 * std::min(1.0, i / 20.0) - 0.001 * std::sin(0.11 * i);
    return Vec3(radius * std::sin(polar) * std::cos(azimuth), radius * std::sin(polar) * std::sin(azimuth), radius * std::cos(polar));
  };
  proxy->reset(device(0));
  reference->reset(device(0));
  double worst = 0.0;
  int contacts = 0;
  for (int i = 0; i < kSteps; ++i) {
    const MethodOutput is = proxy->step({.p_SD = device(i)});
    const MethodOutput should = reference->step({.p_SD = device(i)});
    ASSERT_EQ(is.contact, should.contact) << "step " << i;
    if (!should.contact) continue;
    ++contacts;
    const double error = (is.force_n - should.force_n).norm() / should.force_n.norm();
    ASSERT_LE(error, 1e-6) << "step " << i;
    worst = std::max(worst, error);
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_GT(contacts, 200);
  const ProxyCounters& counters = static_cast<const ProxyMethod&>(*proxy).counters();
  EXPECT_EQ(counters.unconverged, 0U);
  EXPECT_EQ(counters.exhausted, 0U);
}

}  // namespace
}  // namespace hapton
