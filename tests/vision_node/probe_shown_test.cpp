#include "vision_node/probe_shown.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/math/rotation_vector.h"

namespace hapton {
namespace {

constexpr PictureSize kWatchedSize{640, 720};

TEST(ShowProbe, AddsTheVisualOffset) {
  ProbeState state;
  state.p_WD = {0.1, 0.2, 0.3};
  state.visual_offset_m = {0.01, 0.0, -0.02};
  EXPECT_LT((make_shown_probe(state).p_WP - Vec3(0.11, 0.2, 0.28)).norm(), 1e-15);
}

TEST(ShowProbe, SurvivesInvalidNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ProbeState state;
  state.p_WD = Vec3::Constant(kNan);
  state.visual_offset_m = Vec3::Constant(std::numeric_limits<double>::infinity());
  state.force_n = Vec3::Constant(kNan);
  state.q_WT.coeffs().setConstant(kNan);
  state.force_limit_n = std::numeric_limits<float>::quiet_NaN();
  const ProbeShown shown = make_shown_probe(state);
  EXPECT_TRUE(shown.p_WP.allFinite() && shown.force_n.allFinite() && shown.q_WT.coeffs().allFinite());
  EXPECT_EQ(shown.force_limit_n, 0.0);
  state.q_WT.coeffs().setZero();
  EXPECT_NEAR(make_shown_probe(state).q_WT.norm(), 1.0, 1e-15);
}

TEST(ShowProbe, LeanTurnsTheBodyUpAndRightAndLeavesTheTip) {
  ProbeState state;
  state.p_WD = {0.1, 0.2, 0.3};
  EXPECT_LT((make_shown_probe(state).q_WT * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-15);
  const ProbeShown leaning = make_shown_probe(state, make_lean(0.7));
  const Vec3 body = leaning.q_WT * Vec3::UnitZ();
  EXPECT_NEAR(body.z(), std::cos(0.7), 1e-12);
  EXPECT_GT(body.x(), 0.2);
  EXPECT_GT(body.y(), 0.2);
  EXPECT_EQ(leaning.p_WP, state.p_WD);
}

TEST(Arrow, IsAsLongAsTheForceUpToItsLimit) {
  const ProbeSizes sizes;
  ProbeShown probe;
  EXPECT_EQ(compute_arrow(probe, sizes), Vec3::Zero());
  probe.force_n = {0.0, 2.0, 0.0};
  EXPECT_LT((compute_arrow(probe, sizes) - Vec3(0.0, 2.0 * sizes.arrow_m_per_n, 0.0)).norm(), 1e-15);
  probe.force_n = {0.0, 0.0, -1000.0};
  EXPECT_LT((compute_arrow(probe, sizes) - Vec3(0.0, 0.0, -sizes.arrow_max_m)).norm(), 1e-15);
}

class Watch : public testing::Test {
 protected:
  Framing framing_ = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  StereoScreen screen_ = compute_screen(framing_, kWatchedSize);
  ProbeSizes sizes_ = scale_probe(framing_);
  double pixel_m_ = screen_.width_m / kWatchedSize.width_px;
  PictureWatch watch_{0.5};
  ProbeShown probe_;
};

TEST_F(Watch, FirstPictureIsAlwaysWanted) { EXPECT_TRUE(watch_.differs(probe_, sizes_, screen_, kWatchedSize)); }

TEST_F(Watch, MotionBelowHalfAPixelIsNotAboveIs) {
  watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  EXPECT_FALSE(watch_.differs(probe_, sizes_, screen_, kWatchedSize));
  probe_.p_WP.x() = 0.4 * pixel_m_;
  EXPECT_FALSE(watch_.differs(probe_, sizes_, screen_, kWatchedSize));
  probe_.p_WP.x() = 0.6 * pixel_m_;
  EXPECT_TRUE(watch_.differs(probe_, sizes_, screen_, kWatchedSize));
}

TEST_F(Watch, SlowDriftAddsUp) {
  watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  int pictures = 0;
  for (int i = 0; i < 1000; ++i) {
    probe_.p_WP.y() += 0.01 * pixel_m_;
    if (!watch_.differs(probe_, sizes_, screen_, kWatchedSize)) continue;
    ++pictures;
    watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  }
  EXPECT_GE(pictures, 17);  // 10 pixels of drift; a picture for each half pixel or a little more
  EXPECT_LE(pictures, 25);
}

TEST_F(Watch, TurningTheStylusAndAGrowingForceAreSeen) {
  watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  ProbeShown turned = probe_;
  turned.q_WT = Eigen::AngleAxisd(0.05, Vec3::UnitX());
  EXPECT_TRUE(watch_.differs(turned, sizes_, screen_, kWatchedSize));
  ProbeShown pushed = probe_;
  pushed.force_n = {0.5, 0.0, 0.0};
  EXPECT_TRUE(watch_.differs(pushed, sizes_, screen_, kWatchedSize));
  ProbeShown limited = probe_;
  limited.force_limit_n = 10.0;
  watch_.note_drawn(limited, sizes_, screen_, kWatchedSize);
  sizes_.arrow_max_m = 0.0;
  limited.force_n = {0.09, 0.0, 0.0};
  EXPECT_FALSE(watch_.differs(limited, sizes_, screen_, kWatchedSize));
  limited.force_n = {0.11, 0.0, 0.0};
  EXPECT_TRUE(watch_.differs(limited, sizes_, screen_, kWatchedSize)) << "the bar, where the arrow is as long as it gets";
  watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  ProbeShown touching = probe_;
  touching.contact = true;
  EXPECT_TRUE(watch_.differs(touching, sizes_, screen_, kWatchedSize));
}

TEST_F(Watch, APointInTheEyesPlaneCountsAsMoved) {
  watch_.note_drawn(probe_, sizes_, screen_, kWatchedSize);
  probe_.p_WP = compute_eye_position(screen_, Eye::left);
  EXPECT_TRUE(watch_.differs(probe_, sizes_, screen_, kWatchedSize));
}

TEST(ShowProbe, KeepsTheDevicesOwnPlace) {
  ProbeState state;
  state.p_WD = Vec3(0.01, 0.02, 0.03);
  state.visual_offset_m = Vec3(0.0, 0.005, 0.0);
  EXPECT_EQ(make_shown_probe(state).p_WD, state.p_WD);
}

TEST(ProbeRadius, IsFoundInWhatTheHapticsNodeSays) {
  EXPECT_EQ(find_probe_radius("name=proxy probe_radius_m=0.015"), 0.015);
  EXPECT_EQ(find_probe_radius("name=proxy probe_radius_m=5e-4 friction=0.2"), 5e-4);
  EXPECT_EQ(find_set_size("name=smooth set_size=128 smooth_radius_m=0"), 128);
  for (const char* method_text : {"", "name=proxy", "set_size=-3", "set_size=many"})
    EXPECT_EQ(find_set_size(method_text), 64) << method_text;
  for (const char* method_text : {"", "name=proxy", "probe_radius_m=", "probe_radius_m=-1", "probe_radius_m=nan", "probe_radius_m=inf"}) {
    EXPECT_EQ(find_probe_radius(method_text), 0.0) << method_text;
  }
}

TEST(ProbeShown, AToolTurnsFromTheStylusAndDoesNotLean) {
  ProbeState state;
  state.q_WT = turn_by({0.0, 0.0, 0.3});
  state.visual_turn = {0.1, 0.0, 0.0};
  const ProbeShown shown = make_shown_probe(state, make_lean(0.7));
  EXPECT_LT(turn_between(shown.q_WP, turn_by({0.1, 0.0, 0.0}) * state.q_WT).norm(), 1e-12);
  EXPECT_GT(turn_between(shown.q_WT, shown.q_WP).norm(), 0.5);
  state.visual_turn = Vec3::Constant(std::nan(""));
  EXPECT_LT(turn_between(make_shown_probe(state).q_WP, state.q_WT).norm(), 1e-12);
}

}  // namespace
}  // namespace hapton
