#include "core/force/touch_chain.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

// A half space below a height, felt along z with 1 N/m.
struct Floor {
  double height_m = 0.0;
  bool is_moving = false;
  bool is_second = false;
  int object = 0;
  int felt = 0;
  std::vector<double> resumed_z = {};

  bool moves() const { return is_moving; }
};

MethodOutput step_through(TouchChain& chain, std::vector<Floor>& links, double z) {
  const auto begin = [](Floor&, const Vec3&) {};
  const auto resume = [](Floor& link, const Vec3& p) { link.resumed_z.push_back(p.z()); };
  const auto feel = [](Floor& link, const Vec3& p) {
    ++link.felt;
    MethodOutput output{.force_n = Vec3::Zero(), .p_SP = p};
    if (p.z() >= link.height_m) return output;
    output.contact = true;
    output.p_SP.z() = link.height_m;
    output.force_n = output.p_SP - p;
    output.object = link.object;
    return output;
  };
  return chain.step(links, Vec3(0, 0, z), begin, resume, feel);
}

TEST(TouchChain, EachLinkFollowsTheProxyOfTheOneBefore) {
  TouchChain chain;
  std::vector<Floor> links = {{0.0}, {1.0, true, false, 1}, {0.0, false, true}};
  const MethodOutput felt = step_through(chain, links, -2.0);
  EXPECT_EQ(felt.force_n.z(), 3.0) << "2 by the one that stands still, 1 more by the one that moves";
  EXPECT_EQ(felt.p_SP.z(), 1.0);
  EXPECT_EQ(felt.object, 0) << "with the larger force";
}

TEST(TouchChain, TheSecondLinkTakesPartWhileSomethingPushes) {
  TouchChain chain;
  std::vector<Floor> links = {{0.0}, {1.0, true, false, 1}, {0.0, false, true}};
  (void)step_through(chain, links, 3.0);
  EXPECT_EQ(links[2].felt, 0);
  (void)step_through(chain, links, 0.5);
  EXPECT_EQ(links[2].felt, 1);
  EXPECT_EQ(links[2].resumed_z, (std::vector{3.0})) << "from the proxy of the step before";
  (void)step_through(chain, links, 0.4);
  EXPECT_EQ(links[2].felt, 2);
  EXPECT_EQ(links[2].resumed_z.size(), 1U);
  (void)step_through(chain, links, 3.0);
  (void)step_through(chain, links, 0.5);
  EXPECT_EQ(links[2].resumed_z, (std::vector{3.0, 3.0}));
}

TEST(TouchChain, GoesOnFromWhereItIsPut) {
  TouchChain chain;
  std::vector<Floor> links = {{0.0}, {1.0, true, false, 1}, {0.0, false, true}};
  (void)step_through(chain, links, 0.5);
  chain.go_on_from(Vec3(0, 0, 7.0));
  (void)step_through(chain, links, 0.5);
  EXPECT_EQ(links[2].resumed_z.back(), 7.0);
}

}  // namespace
}  // namespace hapton
