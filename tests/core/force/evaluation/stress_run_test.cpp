#include "core/force/evaluation/stress_run.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

StressCount run_stress(const StressBody& body, const StressSettings& settings, const std::string& method, std::uint64_t episodes,
                       const StressRun::MethodMaker& maker = &make_method) {
  MethodSettings method_settings;
  method_settings.name = method;
  method_settings.reference_substeps = 1;
  auto run = StressRun::make(body, settings, method_settings, maker);
  EXPECT_TRUE(run.has_value());
  StressCount count;
  for (std::uint64_t episode = 0; episode < episodes; ++episode) run->run_episode(episode, count);
  return count;
}

std::string describe(const StressCount& count) {
  std::string text;
  for (const StressFinding& finding : count.findings) {
    text += fmt::format("{} in {} at episode {} step {} ({})\n", name_of(finding.fault), name_of(finding.motion), finding.episode,
                        finding.step, finding.size);
  }
  return text;
}

class EveryBody : public ::testing::TestWithParam<std::string_view> {};

TEST_P(EveryBody, HasNoFaultWithTheReference) {
  const StressBody body = make_stress_body(GetParam());
  const StressCount count = run_stress(body, {.seed = 1}, "reference", 12);
  EXPECT_EQ(count.total_faults(), 0u) << describe(count);
  EXPECT_GT(count.contact_steps, 200u);
}

// At a small, a usual and a large scale, and far from the origin.
TEST_P(EveryBody, HasNoFaultWithTheProxy) {
  const StressBody body = make_stress_body(GetParam());
  std::uint64_t contacts = 0;
  for (const StressSettings& settings : {StressSettings{.seed = 1}, StressSettings{.seed = 2, .scale = 1e-6},
                                         StressSettings{.seed = 3, .scale = 1e6}, StressSettings{.seed = 4, .offset_extents = 1e6}}) {
    const StressCount count = run_stress(body, settings, "proxy", 25);
    EXPECT_EQ(count.total_faults(), 0u) << "scale " << settings.scale << " offset " << settings.offset_extents << " seed " << settings.seed
                                        << '\n'
                                        << describe(count);
    contacts += count.contact_steps;
  }
  EXPECT_GT(contacts, 2000u);
}

TEST_P(EveryBody, IsNeverFallenThroughBySmooth) {
  const StressBody body = make_stress_body(GetParam());
  if (body.probe_share > 0.0) GTEST_SKIP() << "smooth supports only a point probe";
  // Known limits of the method (docs/decisions/0003): jumps by an extent between two blades, and pieces that pass through each other.
  if (GetParam() == "knife-gutter" || GetParam().starts_with("overlapping-parts")) return;
  for (const StressSettings& settings : {StressSettings{.seed = 5}, StressSettings{.seed = 6, .offset_extents = 1e6}}) {
    const StressCount count = run_stress(body, settings, "smooth", 15);
    for (const StressFault fault : {StressFault::fall_through, StressFault::inside, StressFault::through, StressFault::not_finite}) {
      EXPECT_EQ(count.faults[static_cast<std::size_t>(fault)], 0u) << describe(count);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Stress, EveryBody, ::testing::ValuesIn(stress_body_names().begin(), stress_body_names().end()),
                         [](const auto& body) {
                           std::string name(body.param);
                           for (char& c : name) {
                             if (c == '-') c = '_';
                           }
                           return name;
                         });

// ---- Faulty methods: each fault must be found. ----

class FaultyMethod : public ForceMethod {
 public:
  FaultyMethod(std::unique_ptr<ForceMethod> correct, StressFault fault) : correct_(std::move(correct)), fault_(fault) {}
  void reset(const Vec3& p) noexcept override {
    steps_ = 0;
    is_frozen_ = false;
    correct_->reset(p);
  }
  void set_materials(std::span<const Material>) noexcept override {}
  std::string describe() const override { return "wrong"; }
  MethodOutput step(const MethodInput& input) noexcept override {
    MethodOutput felt = correct_->step(input);
    ++steps_;
    if (!felt.contact) return felt;
    switch (fault_) {
      case StressFault::fall_through:
        return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false};
      case StressFault::inside:
        return with_proxy(felt, input.p_SD + 0.5 * (felt.p_SP - input.p_SD), input);
      case StressFault::stuck:
      case StressFault::unconverged:
        if (!is_frozen_) frozen_proxy_ = felt.p_SP;
        is_frozen_ = true;
        return with_proxy(felt, frozen_proxy_, input);
      case StressFault::discontinuity:
        return with_proxy(felt, felt.p_SP + (steps_ % 2 == 0 ? 1e-3 : 0.0) * Vec3::UnitX(), input);
      case StressFault::not_finite:
        felt.force_n.x() = std::numeric_limits<double>::quiet_NaN();
        return felt;
      default:
        felt.force_n *= 1.5;
        return felt;
    }
  }

 private:
  static MethodOutput with_proxy(MethodOutput felt, const Vec3& proxy, const MethodInput& input) {
    felt.p_SP = proxy;
    felt.force_n = 1000.0 * (proxy - input.p_SD);
    return felt;
  }
  std::unique_ptr<ForceMethod> correct_;
  StressFault fault_;
  std::uint64_t steps_ = 0;
  bool is_frozen_ = false;
  Vec3 frozen_proxy_ = Vec3::Zero();
};

// A surface that the hand leaves quickly still holds the proxy, even if damping leaves no force.
TEST(StressRun, ContactWhoseForceDampingTakesIsNoFault) {
  const StressBody body = make_stress_body(stress_body_names().front());
  StressSettings settings{.seed = 1};
  settings.material.damping_ns_per_m = 5.0;
  for (const char* method : {"proxy", "reference"}) {
    const StressCount count = run_stress(body, settings, method, 6);
    EXPECT_EQ(count.total_faults(), 0u) << method << '\n' << describe(count);
    EXPECT_GT(count.contact_steps, 100u) << method;
  }
}

TEST(StressRun, DetectsEveryKindOfFault) {
  for (const StressFault fault : {StressFault::fall_through, StressFault::inside, StressFault::stuck, StressFault::unconverged,
                                  StressFault::discontinuity, StressFault::not_finite, StressFault::broken}) {
    const auto maker = [&](const MethodSettings& settings, const TouchScene& scene) -> Result<std::unique_ptr<ForceMethod>> {
      auto correct = make_method(settings, scene);
      if (!correct) return correct;
      return std::make_unique<FaultyMethod>(std::move(*correct), fault);
    };
    const StressBody body = make_stress_body(fault == StressFault::discontinuity ? "turned-room" : "sphere");
    const StressCount count = run_stress(body, {.seed = 1, .compare_every = 8}, "reference", 20, maker);
    EXPECT_GT(count.faults[static_cast<std::size_t>(fault)], 0u) << name_of(fault);
    ASSERT_FALSE(count.findings.empty());
  }
}

// A correct method: where the device, behind one wall, comes to the plane of another wall, it puts the proxy on that plane, exactly or one
// unit in the last place beyond it. The position of the proxy then does not show on which side of that wall it is.
class OnTheThirdWall : public ForceMethod {
 public:
  OnTheThirdWall(std::unique_ptr<ForceMethod> correct, const Vec3& half) : correct_(std::move(correct)), half_(half) {}
  void reset(const Vec3& p) noexcept override { correct_->reset(p); }
  void set_materials(std::span<const Material>) noexcept override {}
  std::string describe() const override { return "on the third wall"; }
  MethodOutput step(const MethodInput& input) noexcept override {
    MethodOutput felt = correct_->step(input);
    if (!felt.contact || !input.p_SD.allFinite()) return felt;
    for (int k = 0; k < 3; ++k) {
      const double wall = std::copysign(std::nextafter(half_[k], 1.0), felt.p_SP[k]);
      if (!(std::fabs(felt.p_SP[k] - wall) < 1e-10 && std::fabs(input.p_SD[k] - wall) < 1e-10)) continue;
      felt.p_SP[k] = wall;
      felt.force_n = 1000.0 * (felt.p_SP - input.p_SD);
      ++moved_steps_;
    }
    return felt;
  }
  static inline int moved_steps_ = 0;

 private:
  std::unique_ptr<ForceMethod> correct_;
  Vec3 half_;
};

TEST(StressRun, AProxyExactlyOnAWallIsComparedFromTheFreeSide) {
  const StressBody body = make_stress_body("room");
  const auto maker = [&](const MethodSettings& settings, const TouchScene& scene) -> Result<std::unique_ptr<ForceMethod>> {
    auto correct = make_method(settings, scene);
    if (!correct) return correct;
    return std::make_unique<OnTheThirdWall>(std::move(*correct), compute_bounds(body.touched).high);
  };
  OnTheThirdWall::moved_steps_ = 0;
  const StressCount count = run_stress(body, {.seed = 1, .compare_every = 1}, "reference", 40, maker);
  EXPECT_GT(OnTheThirdWall::moved_steps_, 100);
  EXPECT_GT(count.compared_steps, 1000U);
  EXPECT_EQ(count.faults[static_cast<std::size_t>(StressFault::unconverged)], 0u) << describe(count);
  EXPECT_EQ(count.faults[static_cast<std::size_t>(StressFault::stuck)], 0u) << describe(count);
}

// Moves through every surface without force.
class MethodWithoutForce : public ForceMethod {
 public:
  void reset(const Vec3&) noexcept override {}
  void set_materials(std::span<const Material>) noexcept override {}
  std::string describe() const override { return "nothing"; }
  MethodOutput step(const MethodInput& input) noexcept override { return {.force_n = Vec3::Zero(), .p_SP = input.p_SD, .contact = false}; }
};

TEST(StressRun, ReportsAProbeThatGoesThroughAnOpenSheet) {
  const auto maker = [](const MethodSettings&, const TouchScene&) -> Result<std::unique_ptr<ForceMethod>> {
    return std::make_unique<MethodWithoutForce>();
  };
  const StressBody sheet = make_stress_body("sheet", make_plane_grid(0.1, 8));
  EXPECT_GT(run_stress(sheet, {}, "none", 20, maker).faults[static_cast<std::size_t>(StressFault::through)], 0u);
  const StressCount with_reference = run_stress(sheet, {}, "reference", 20);
  EXPECT_EQ(with_reference.total_faults(), 0u) << describe(with_reference);
}

TEST(StressRun, AnEpisodeCanBeRunAgainAlone) {
  const StressBody body = make_stress_body("bumpy");
  MethodSettings method;
  method.name = "reference";
  method.reference_substeps = 1;
  auto first = StressRun::make(body, {.seed = 9}, method);
  auto second = StressRun::make(body, {.seed = 9}, method);
  StressCount after_others, alone, before;
  for (std::uint64_t episode = 0; episode < 4; ++episode) first->run_episode(episode, episode < 3 ? before : after_others);
  second->run_episode(3, alone);
  EXPECT_EQ(after_others.steps, alone.steps);
  EXPECT_EQ(after_others.contact_steps, alone.contact_steps);
  EXPECT_EQ(after_others.compared_steps, alone.compared_steps);
}

TEST(StressRun, SaysWhichFaultsItCovers) {
  const auto covers = [](const StressBody& body, const Material& material, StressFault fault) {
    return run_stress(body, {.material = material}, "reference", 1).covered[static_cast<std::size_t>(fault)];
  };
  const Material rough{.friction_static = 0.5, .friction_dynamic = 0.4};
  const StressBody ball = make_stress_body("sphere"), room = make_stress_body("room"), sheet{"sheet", make_plane_grid(0.1, 4), {}};
  EXPECT_TRUE(covers(room, {}, StressFault::discontinuity));
  EXPECT_FALSE(covers(room, rough, StressFault::discontinuity));
  EXPECT_FALSE(covers(ball, {}, StressFault::discontinuity));
  EXPECT_TRUE(covers(ball, {}, StressFault::fall_through));
  EXPECT_FALSE(covers(sheet, {}, StressFault::fall_through));
  EXPECT_TRUE(covers(sheet, {}, StressFault::through));
  EXPECT_FALSE(covers(ball, {}, StressFault::through));
  EXPECT_TRUE(covers(ball, {}, StressFault::unconverged));
  EXPECT_FALSE(covers(ball, rough, StressFault::unconverged));
  EXPECT_TRUE(covers(sheet, rough, StressFault::broken));
}

TEST(StressRun, EveryFaultHasANameAndAMeaning) {
  std::set<std::string_view> names, meanings;
  for (int i = 0; i < static_cast<int>(StressFault::count); ++i) {
    names.insert(name_of(static_cast<StressFault>(i)));
    meanings.insert(meaning_of(static_cast<StressFault>(i)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(StressFault::count));
  EXPECT_EQ(meanings.size(), names.size());
}

}  // namespace
}  // namespace hapton
