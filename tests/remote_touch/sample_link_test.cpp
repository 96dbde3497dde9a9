#include "remote_touch/sample_link.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/force/force_method.h"
#include "remote_touch/machine_stalls.h"
#include "remote_touch/packet_size.h"
#include "remote_touch/remote_deadband.h"
#include "remote_touch/remote_plane.h"
#include "tests/support/made_scene.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

std::shared_ptr<ForceMethod> sheet_method(double stiffness_n_per_m = 1000.0) {
  return *make_method({}, scene_of(made::sheet(0.05, 0.0, 4), {.stiffness_n_per_m = stiffness_n_per_m}));
}

Vec3 at_depth(double depth_m) { return {0.001, 0.002, -depth_m}; }

TEST(SampleLink, EachSampleGetsAReplyARoundTripLater) {
  SampleLink link(sheet_method(), {.up = {.delay_ns = 2 * kMs}, .down = {.delay_ns = 3 * kMs}});
  for (int n = 0; n < 20; ++n) {
    const std::int64_t now_ns = (100 + n) * kMs;
    const auto reply = link.exchange({now_ns, at_depth(1e-4 * n)});
    ASSERT_EQ(link.received().has_value(), n >= 2);
    if (n >= 2) {
      EXPECT_EQ(link.received()->time_ns, now_ns - 2 * kMs);
    }
    ASSERT_EQ(reply.has_value(), n >= 5);
    if (n >= 5) {
      EXPECT_EQ(reply->sample.time_ns, now_ns - 5 * kMs);
      EXPECT_NEAR(reply->touch.force_n.norm(), 1000.0 * 1e-4 * (n - 5), 1e-9);
    }
  }
  EXPECT_EQ(link.traffic().up.packets, 20U);
  EXPECT_EQ(link.traffic().up.bytes, 20U * packet_bytes_of_state());
  EXPECT_EQ(link.traffic().down.packets, 18U);
  EXPECT_EQ(link.traffic().down.bytes, 18U * packet_bytes_of_force());
  EXPECT_EQ(link.traffic().scene.packets, 0U);
}

TEST(SampleLink, SendsNoMoreOftenThanItsPeriod) {
  SampleLink link(sheet_method(), {}, 5 * kMs);
  int replies = 0;
  for (int n = 0; n < 20; ++n) {
    const bool is_due = n % 5 == 0;
    const auto reply = link.exchange({(100 + n) * kMs, at_depth(0.001)});
    EXPECT_EQ(reply.has_value(), is_due) << n;
    EXPECT_EQ(link.received().has_value(), is_due) << n;
    replies += reply ? 1 : 0;
  }
  EXPECT_EQ(replies, 4);
  EXPECT_EQ(link.traffic().up.packets, 4U);
}

TEST(SampleLink, OlderRepliesAndCopiesAreDropped) {
  SampleLink link(sheet_method(), {.up = {.jitter_ns = 10 * kMs, .duplicate = 0.5}, .down = {.jitter_ns = 10 * kMs, .duplicate = 0.5}});
  std::int64_t last_ns = 0;
  int replies = 0;
  for (int n = 0; n < 300; ++n) {
    const auto reply = link.exchange({(100 + n) * kMs, at_depth(0.001)});
    if (!reply) continue;
    EXPECT_GT(reply->sample.time_ns, last_ns);
    last_ns = reply->sample.time_ns;
    ++replies;
  }
  EXPECT_GT(replies, 30);
  EXPECT_LT(replies, 250);
}

TEST(RemotePlane, PushesOneWayAndEndsWithTheContact) {
  RemotePlane plane(sheet_method(), {.up = {.delay_ns = 3 * kMs}});
  std::int64_t now_ns = 100 * kMs;
  const auto hold = [&](double depth_m) {
    Vec3 force = Vec3::Zero();
    for (int n = 0; n < 10; ++n) force = plane.step(at_depth(depth_m), now_ns += kMs).force_n;
    return force;
  };
  EXPECT_EQ(hold(-0.002), Vec3(Vec3::Zero()));
  EXPECT_NEAR(hold(0.002).z(), 2.0, 1e-9);
  EXPECT_NEAR(plane.step(at_depth(0.003), now_ns += kMs).force_n.z(), 3.0, 1e-6) << "at once, by the plane that is known";
  EXPECT_EQ(plane.step(at_depth(-0.001), now_ns += kMs).force_n, Vec3(Vec3::Zero())) << "it does not pull";
  EXPECT_EQ(hold(-0.001), Vec3(Vec3::Zero()));
  EXPECT_EQ(plane.step(at_depth(0.003), now_ns += kMs).force_n, Vec3(Vec3::Zero())) << "no plane is left of a contact that is over";
}

// Replies with an offset of the proxy and a force that need not fit each other.
class FixedOutput final : public ForceMethod {
 public:
  MethodOutput output;  // p_SP is relative to the device

  MethodOutput step(const MethodInput& input) noexcept override {
    MethodOutput made = output;
    made.p_SP += input.p_SD;
    return made;
  }
  void reset(const Vec3&) noexcept override {}
  void set_materials(std::span<const Material>) noexcept override {}
  std::string describe() const override { return ""; }
};

TEST(RemotePlane, ExistsOnlyWithContactAndAnOffsetToTheSurface) {
  const auto method = std::make_shared<FixedOutput>();
  RemotePlane plane(method, {});
  const Vec3 p_WD(0.01, 0.02, 0.03);
  std::int64_t now_ns = 100 * kMs;
  const auto force = [&](bool contact, const Vec3& offset, const Vec3& below = Vec3::Zero()) {
    method->output = {.force_n = Vec3(0, 0, 2), .p_SP = offset, .contact = contact, .object = contact ? 0 : -1};
    (void)plane.step(p_WD, now_ns += kMs);
    method->output = {};
    return plane.step(p_WD + below, now_ns).force_n;
  };
  EXPECT_LT((force(true, Vec3(0, 0, 0.002)) - Vec3(0, 0, 2)).norm(), 1e-9);
  EXPECT_LT((force(true, Vec3(0, 0, 0.002), Vec3(0.01, 0, -0.001)) - Vec3(0, 0, 3)).norm(), 1e-9) << "the same plane deeper";
  EXPECT_LT((force(true, Vec3(0.004, 0, 0)) - Vec3(2, 0, 0)).norm(), 1e-9)
      << "its stiffness is the force's magnitude over the offset's length";
  EXPECT_EQ(force(false, Vec3(0, 0, 0.002)), Vec3(Vec3::Zero()));
  EXPECT_EQ(force(true, Vec3::Zero()), Vec3(Vec3::Zero()));
  EXPECT_EQ(force(true, Vec3::Zero(), Vec3(0, 0, -0.001)), Vec3(Vec3::Zero()));
}

// Packets that are sent in a second for a hand that moves like this, with a deadband of a tenth.
std::uint64_t packets_up(const std::function<Vec3(double)>& hand) {
  RemoteDeadband touch(sheet_method(), {}, {.fraction = 0.1});
  for (int n = 0; n < 1000; ++n) (void)touch.step(hand(1e-3 * n), (1000 + n) * kMs);
  return touch.traffic().up.packets;
}

TEST(RemoteDeadband, AHandWhoseVelocityIsKnownNeedsNoPackets) {
  EXPECT_EQ(packets_up([](double) { return at_depth(-0.01); }), 1U) << "at rest";
  const auto steady_packets = packets_up([](double t_s) { return Vec3(0.1 * t_s, 0, 0.01); });
  EXPECT_LT(steady_packets, 10U) << "until its speed is known";
  EXPECT_GE(steady_packets, 2U);
  // This hand turns back every tenth of a second.
  const auto turning_packets = packets_up([](double t_s) { return Vec3(0.1 * std::fabs(std::fmod(t_s, 0.2) - 0.1), 0, 0.01); });
  EXPECT_GT(turning_packets, 3 * steady_packets);
  EXPECT_LT(turning_packets, 400U);
}

// A motion slower than any speed that counts is sent when the extrapolated position is off by a tenth of a millimetre.
TEST(RemoteDeadband, ASlowHandIsSentWhenItsExtrapolationIsOff) {
  const double speed_m_per_s = 0.004;  // less than a tenth of kMinSpeed
  const auto packets = packets_up([&](double t_s) { return Vec3(speed_m_per_s * t_s, 0, 0.01); });
  EXPECT_GE(packets, 2U);
  EXPECT_LE(packets, 1 + static_cast<std::uint64_t>(speed_m_per_s / (0.1 * RemoteDeadband::kPositionM)));
}

TEST(RemoteDeadband, ContactIsReportedAtOnceWhenItBeginsAndEnds) {
  RemoteDeadband touch(sheet_method(10.0), {}, {.fraction = 0.5});
  std::int64_t now_ns = 1000 * kMs;
  const auto packets_after = [&](double depth_m) {
    for (int n = 0; n < 100; ++n) (void)touch.step(at_depth(depth_m), now_ns += kMs);
    return touch.traffic().down.packets;
  };
  const auto packets_before = packets_after(-0.002);
  // 20 mN is less than half of kMinForceN. Every force below kMinForceN counts as kMinForceN.
  const auto packets_in_contact = packets_after(0.002);
  EXPECT_EQ(packets_in_contact, packets_before + 1);
  EXPECT_EQ(packets_after(0.002), packets_in_contact);
  EXPECT_EQ(packets_after(-0.002), packets_in_contact + 1);
}

TEST(MachineStalls, WithoutALengthThereAreNone) {
  MachineStalls stalls(0.0, 1e-3, 1);
  for (std::size_t row = 0; row < 100'000; ++row) ASSERT_EQ(stalls.missed_before(row), 0U);
}

TEST(MachineStalls, HaveTheirMeanLengthAndMeanGap) {
  constexpr double kMeanRows = 50.0;  // 0.05 s in rows of 1 ms
  MachineStalls stalls(0.05, 1e-3, 7);
  double missed = 0.0;
  int count = 0;
  std::size_t row = 0;
  std::size_t longest = 0;
  for (; row < 2'000'000; ++row) {
    const std::size_t stall_rows = stalls.missed_before(row);
    if (stall_rows == 0) continue;
    EXPECT_EQ(stalls.missed_before(row + stall_rows), 0U) << "a row follows each stall";
    longest = std::max(longest, stall_rows);
    missed += static_cast<double>(stall_rows);
    row += stall_rows;
    ++count;
  }
  EXPECT_NEAR(missed / count, kMeanRows, 0.05 * kMeanRows);
  EXPECT_NEAR((static_cast<double>(row) - missed) / count, 1e3 * MachineStalls::kGapS, 0.05 * 1e3 * MachineStalls::kGapS);
  EXPECT_LE(longest, static_cast<std::size_t>(MachineStalls::kMaxOverMean * kMeanRows));
  EXPECT_GT(longest, static_cast<std::size_t>(0.8 * MachineStalls::kMaxOverMean * kMeanRows));
}

}  // namespace
}  // namespace hapton
