// Whole programs that die, freeze or are cut off, while the force comes from the haptics node and while it comes from
// patches of the scene beside the device. The exact bounds are those of tests/faults, on simulated time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/process/system.h"
#include "tests/process/watched_force.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

constexpr double kTopM = 0.05;  // height of the cube's top
// A height above the top at which the hand is free: from where it starts it comes down, and swings 4 mm below this height.
constexpr double kFreeHeightM = 0.015;

// How io_node gets its forces, and through which network. With the round trip of kAutoFar, `auto` uses no remote force.
struct TouchSetup {
  std::string name;
  std::string touch;
  std::vector<std::string> relay;  // empty: no relay
};
const TouchSetup kRemote = {"Remote", "remote", {}};
const TouchSetup kPatch = {"Patch", "patch", {}};
const TouchSetup kAutoFar = {"AutoFar", "auto", {"--delay-ms", "25"}};
const TouchSetup kPatchLossy = {
    "PatchLossy", "patch", {"--delay-ms", "10", "--loss", "0.3", "--jitter-ms", "20", "--duplicate", "0.1", "--corrupt", "0.05"}};

class FaultsInContact : public ::testing::TestWithParam<TouchSetup> {
 protected:
  bool has_patches() const { return GetParam().touch != "remote"; }

  // The hand comes down onto the cube and stays in contact.
  void press(bool through_relay = false) {
    // The hand starts above the cube: a program that first meets a hand inside a body cannot know where it came in.
    std::ofstream(system.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.065\n600,0.01,0.02,0.065\n";
    system.add_arguments("io_node", {"--trajectory", (system.folder() / "taps.csv").string()});
    start("io_node");
    if (through_relay || !GetParam().relay.empty()) system.start_relay(GetParam().relay);
    start("haptics_node");
    observer.emplace(system);
    ASSERT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "forces") > 0; }));
    press_in();
    if (has_patches()) {
      ASSERT_TRUE(feels_patches(system)) << "no patches";
    }
    expect_felt();
  }
  void press_in() {
    observer->lead_hand(Vec3(0.01, 0.02, kTopM - 0.0025));
    ASSERT_TRUE(observer->wait_for_force(state)) << "no contact";
  }
  void start(const std::string& name) { system.start(name); }
  // As waits_for, but keeps the hand led: the hub leads it for only a second after the last message of the observer. Otherwise the hand
  // would rise, and a haptics node that joins while it is led down again would first meet it inside the cube, with no known contact.
  bool waits_while_leading(const std::function<bool(const Json&)>& holds) {
    return waits_for(system, [&](const Json& report) { return receives_newest() && holds(report); });
  }
  bool receives_newest() {
    const std::int64_t now_ns = observer->now_ns();
    while (observer->receive_state(state)) {
      if (observer->sent_ns() >= now_ns) return true;
    }
    return false;
  }

  // The force ends, and does not come back by itself. A force from patches ends a second after the last message of the haptics node;
  // until then, a machine that stands still may interrupt it for a moment.
  void expect_released() {
    const std::int64_t deadline_ns = observer->now_ns() + 5 * kNanosecondsPerSecond;
    for (int released = 0; released < 300;) {
      ASSERT_TRUE(observer->receive_state(state));
      const bool is_released = state.force_n == Vec3::Zero() && !state.contact;
      released = is_released ? released + 1 : 0;
      ASSERT_TRUE(is_released || state.sample_time_ns < deadline_ns) << "the force stays, or comes back: " << state.force_n.transpose();
    }
  }
  // A force comes that fits the press of the hand: more than 0.2 N upwards, and within its limits.
  void expect_felt() {
    bool is_felt = false;
    for (const std::int64_t end_ns = observer->now_ns() + std::int64_t(1e9 * kPatience.count()); !is_felt && observer->now_ns() < end_ns;) {
      ASSERT_TRUE(observer->receive_state(state));
      is_felt = state.contact && state.force_n.z() > 0.2;
    }
    EXPECT_TRUE(is_felt) << "the hand is at " << state.p_WD.transpose() << "\n" << system["io_node"].err() << system["haptics_node"].err();
    EXPECT_GT(expect_within_limits(*observer, 0.5, Until::force).forces, 0);
  }
  void expect_felt_again() {
    expect_felt();
    if (has_patches()) {
      const std::int64_t before = count(system.request_report(), "local_forces");
      EXPECT_TRUE(waits_while_leading([&](const Json& report) { return count(report, "local_forces") > before + 100; }))
          << "patches do not take over again";
    }
    expect_felt();
    const Json report = system.request_report();
    expect_sane(report);
    EXPECT_EQ(report.at("notes").at("safety_fault"), "none");
  }

  System system{[] {
    std::vector<std::string> options = tight_limits(GetParam().touch);
    options.insert(options.end(), {"--device", "simulated"});
    return options;
  }()};
  std::optional<SessionObserver> observer;
  ProbeState state;
};

TEST_P(FaultsInContact, HapticsKilledLeavesNoForceAndBringsItBack) {
  ASSERT_NO_FATAL_FAILURE(press());
  system["haptics_node"].kill();
  ASSERT_NO_FATAL_FAILURE(expect_released());
  start("haptics_node");
  expect_felt_again();
  system.end_all();
}

// The programs that still run remember where the contact was. If the hand has left meanwhile, that contact must not pull it back.
TEST_P(FaultsInContact, NothingPullsAHandBackThatHasLeftMeanwhile) {
  ASSERT_NO_FATAL_FAILURE(press());
  for (const char* node : {"haptics_node", "io_node"}) {
    system[node].kill();
    const std::int64_t killed_ns = observer->now_ns();
    if (node == std::string("haptics_node")) {
      ASSERT_NO_FATAL_FAILURE(expect_released());
      observer->lead_hand(Vec3(0.01, 0.02, kTopM + kFreeHeightM));
      ASSERT_TRUE(System::wait_until([&] { return observer->receive_state(state) && state.p_WD.z() > kTopM + kFreeHeightM - 0.0005; }));
    }
    start(node);
    const std::int64_t before = node == std::string("haptics_node") ? count(system.request_report(), "forces") : 0;
    ASSERT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "forces") > before + 20; }));
    observer->lead_hand(Vec3(0.01, 0.02, kTopM + kFreeHeightM));
    for (int n = 0; n < 300; ++n) {
      do {  // what the hub sent before it was killed may still be queued
        ASSERT_TRUE(observer->receive_state(state));
      } while (state.sample_time_ns < killed_ns);
      ASSERT_EQ(state.force_n, Vec3::Zero()) << node << ": sample " << state.sample << ", hand at " << state.p_WD.transpose() << ", " << n
                                             << " seen, " << 1e-6 * static_cast<double>(state.sample_time_ns - killed_ns)
                                             << " ms after it was killed";
      ASSERT_FALSE(state.contact);
    }
    ASSERT_NO_FATAL_FAILURE(press_in());
    expect_felt();
  }
  system.end_all();
}

TEST_P(FaultsInContact, HapticsFrozenLeavesNoForceAndBringsItBack) {
  ASSERT_NO_FATAL_FAILURE(press());
  system["haptics_node"].send_signal(SIGSTOP);
  ASSERT_NO_FATAL_FAILURE(expect_released());
  system["haptics_node"].send_signal(SIGCONT);
  expect_felt_again();
  system.end_all();
}

// When the relay continues, it sends all datagrams that it held back at once.
TEST_P(FaultsInContact, TheNetworkCutLeavesNoForceAndBringsItBack) {
  ASSERT_NO_FATAL_FAILURE(press(true));
  system["relay"].send_signal(SIGSTOP);
  ASSERT_NO_FATAL_FAILURE(expect_released());
  system["relay"].send_signal(SIGCONT);
  expect_felt_again();
  system.end_all();
}

TEST_P(FaultsInContact, ASecondHapticsNodeTakesOver) {
  ASSERT_NO_FATAL_FAILURE(press());
  const auto second = system.start_another("haptics_node");
  ASSERT_TRUE(waits_while_leading([](const Json& report) { return count(report, "joins_rejected") > 0; }));
  expect_felt();
  system["haptics_node"].kill();
  ASSERT_TRUE(System::wait_until([&] { return receives_newest() && second->err().find("joined the hub") != std::string::npos; }));
  expect_felt_again();
  EXPECT_FALSE(HasFailure()) << second->err();
  second->send_signal(SIGTERM);
  EXPECT_TRUE(second->wait(kPatience));
}

TEST_P(FaultsInContact, TheForceReturnsAfterTheHubIsKilledAndRestarted) {
  ASSERT_NO_FATAL_FAILURE(press());
  system["io_node"].kill();
  start("io_node");
  expect_felt_again();
  system.end_all();
}

TEST_P(FaultsInContact, TheForceReturnsAfterTheHubIsFrozenAndContinued) {
  ASSERT_NO_FATAL_FAILURE(press());
  SteadyClock clock;
  for (const int ms : {50, 1500}) {
    system["io_node"].send_signal(SIGSTOP);
    clock.sleep_until_ns(clock.now_ns() + ms * kNanosecondsPerMillisecond);
    system["io_node"].send_signal(SIGCONT);
    expect_felt_again();
  }
  system.end_all();
}

// The scene moves up by half a millimetre and turns about z: the hand is then half a millimetre deeper.
TEST_P(FaultsInContact, AMovedSceneIsFeltWhereItIs) {
  ASSERT_NO_FATAL_FAILURE(press());
  ViewTransform view;
  view.revision = 5;
  view.X_WS = {0.8F, -0.6F, 0.0F, 0.0F, 0.6F, 0.8F, 0.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0005F};
  bool is_there = false;
  for (int n = 0; n < 20'000 && !is_there; ++n) {
    if (n % 100 == 0) observer->send(view);
    ASSERT_TRUE(observer->receive_state(state));
    is_there = state.contact && state.view_revision == 5 && std::abs(state.p_WD.z() + state.visual_offset_m.z() - kTopM - 0.0005) < 1e-6;
  }
  EXPECT_TRUE(is_there) << state.p_WD.z() + state.visual_offset_m.z();
  expect_felt_again();
  system.end_all();
}

// 257 effects that are too weak to be felt: one more than patches can hold.
std::string many_effects() {
  std::string lines;
  for (int n = 0; n < 257; ++n) lines += "[[effect]]\ntype = \"viscous\"\ndamping_ns_per_m = 0.000001\n";
  return lines;
}

// The file is saved with the cube half a millimetre lower, then with honey on it, and then with more effects than patches can hold.
TEST_P(FaultsInContact, ASceneThatIsSavedAgainIsFelt) {
  system.add_arguments("haptics_node", {"--watch-scene"});
  ASSERT_NO_FATAL_FAILURE(press());
  const auto save = [&](const std::string& lines) {
    std::ofstream(system.folder() / "cube.toml") << "[[object]]\nmesh = \"cube.obj\"\nunit = \"m\"\nposition_m = [0, 0, -0.0005]\n"
                                                 << lines;
  };
  save("");
  bool is_lower = false;
  for (int n = 0; n < 20'000 && !is_lower; ++n) {
    ASSERT_TRUE(observer->receive_state(state));
    is_lower = state.contact && std::abs(state.p_WD.z() + state.visual_offset_m.z() - kTopM + 0.0005) < 1e-6;
  }
  EXPECT_TRUE(is_lower) << state.p_WD.z() + state.visual_offset_m.z() << system["haptics_node"].err();
  expect_felt_again();
  if (has_patches() && GetParam().name != "AutoFar") {
    save("material = \"honey\"\n[material.honey]\nviscosity_ns_per_m = 0.1\n");
    expect_felt_again();
    save(many_effects());
    EXPECT_TRUE(
        System::wait_until([&] { return system["haptics_node"].err().find("but the scene has more than 256") != std::string::npos; }));
    SteadyClock clock;
    EXPECT_TRUE(System::wait_until([&] {
      const std::int64_t before = count(system.request_report(), "local_forces");
      clock.sleep_until_ns(clock.now_ns() + 100 * kNanosecondsPerMillisecond);
      return count(system.request_report(), "local_forces") == before;
    })) << "the force is remote";
    save("");
    expect_felt_again();
  }
  system.end_all();
}

void PrintTo(const TouchSetup& setup, std::ostream* out) { *out << setup.name; }

INSTANTIATE_TEST_SUITE_P(All, FaultsInContact, ::testing::Values(kRemote, kPatch, kAutoFar, kPatchLossy),
                         [](const auto& setup) { return setup.param.name; });

// A scene or options that patches do not support: the force comes from the haptics node, and a line says why.
struct RemoteOnly {
  std::string name;
  std::string scene;
  std::vector<std::string> haptics;
  std::string line;
};
void PrintTo(const RemoteOnly& remote_only, std::ostream* out) { *out << remote_only.name; }

class TouchUnserved : public ::testing::TestWithParam<RemoteOnly> {};

TEST_P(TouchUnserved, IsFeltFromTheHapticsNodeAndALineSaysWhy) {
  System system({"--touch", "patch"});
  std::ofstream(system.folder() / "cube.toml") << GetParam().scene;
  system.add_arguments("haptics_node", GetParam().haptics);
  system.start("io_node");
  system.start("haptics_node");
  EXPECT_TRUE(System::wait_until([&] { return system["haptics_node"].err().find(GetParam().line) != std::string::npos; }))
      << system["haptics_node"].err();
  EXPECT_TRUE(waits_for(system, [](const Json& report) {
    return count(report, "contact_samples") > 300 && std::stod(report.at("notes").at("max_force_written_n").get<std::string>()) > 0.5;
  }));
  EXPECT_EQ(count(system.request_report(), "local_forces"), 0);
  system.end_all();
}

const std::string kPlainScene = "[[object]]\nmesh = \"cube.obj\"\nunit = \"m\"\n";
INSTANTIATE_TEST_SUITE_P(
    All, TouchUnserved,
    ::testing::Values(RemoteOnly{"Shading", kPlainScene, {"--shading", "1"}, "but force shading is on: this node computes the forces"},
                      RemoteOnly{"Method", kPlainScene, {"--method", "sweep"}, "but the method is not proxy: this node computes"},
                      RemoteOnly{"Clay",
                                 kPlainScene + "sculpt = true\nvoxel_mm = 2.0\ntool_radius_mm = 4.0\n",
                                 {},
                                 "but objects of the scene can be carved: this node computes"},
                      RemoteOnly{"Effects", kPlainScene + many_effects(), {}, "but the scene has more than 256 effects in free space"}),
    [](const auto& remote_only) { return remote_only.param.name; });

// Over a slow and lossy network a hand moves the cube 20 mm aside. Forces from patches are felt where the cube lies, before and after.
TEST(TouchOfMovableObjects, IsFromPatchesWhereTheyLie) {
  System system({"--touch", "patch", "--device", "simulated"});
  std::ofstream(system.folder() / "cube.toml") << kPlainScene << "movable = true\n" << kPlainScene << "position_m = [0, 0, -0.2]\n";
  std::ofstream(system.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.065\n600,0.01,0.02,0.065\n";
  system.add_arguments("io_node", {"--trajectory", (system.folder() / "taps.csv").string()});
  system.start("io_node");
  system.start_relay({"--delay-ms", "20", "--loss", "0.1", "--jitter-ms", "10", "--duplicate", "0.1"});
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  const auto sees = [&](const auto& holds) {
    const std::int64_t end_ns = observer.now_ns() + std::int64_t(1e9 * kPatience.count());
    while (observer.now_ns() < end_ns && observer.receive_state(state)) {
      if (holds()) return true;
    }
    return false;
  };
  const auto touches = [&] { return state.contact && state.force_n.z() > 0.2; };
  int samples_at_rest = 0;
  Vec3 before = Vec3::Zero();
  const auto rests = [&] {
    samples_at_rest = (std::exchange(before, state.p_WD) - state.p_WD).norm() < 2e-5 ? samples_at_rest + 1 : 0;
    return samples_at_rest > 100;
  };
  ASSERT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "forces") > 0; }));
  const Vec3 on_it(0.01, 0.02, kTopM - 0.0025);
  const Vec3 aside(0.02, 0.0, 0.0);
  observer.lead_hand(on_it);
  ASSERT_TRUE(sees(touches)) << system["haptics_node"].err();
  ASSERT_TRUE(feels_patches(system));
  ASSERT_TRUE(sees(rests));
  observer.lead_hand(on_it, 1);
  ASSERT_TRUE(sees([&] { return observer.object_pose().is_held; })) << system["haptics_node"].err();
  observer.lead_hand(on_it + aside, 1);
  ASSERT_TRUE(sees([&] { return rests() && (state.p_WD - on_it - aside).norm() < 0.001; })) << state.p_WD.transpose();
  observer.lead_hand(on_it + aside);
  ASSERT_TRUE(sees([&] { return !observer.object_pose().is_held && observer.object_pose().p_m.x() > 0.015; }));
  ASSERT_TRUE(sees([&] { return state.contact; })) << "where it was put down: " << state.p_WD.transpose();
  EXPECT_TRUE(feels_patches(system));
  observer.lead_hand(on_it + aside - Vec3(0, 0, 0.002));
  ASSERT_TRUE(sees(touches)) << state.p_WD.transpose();
  // The hand goes beside the cube, to where the cube was before.
  const Vec3 beside(-0.045, 0.02, kTopM - 0.01);
  observer.lead_hand(beside);
  EXPECT_TRUE(sees([&] { return (state.p_WD - beside).norm() < 0.001 && !state.contact && state.force_n.isZero(0.0); }))
      << state.p_WD.transpose() << ": " << state.force_n.transpose();
  EXPECT_TRUE(feels_patches(system));
  const Json report = system.request_report();
  expect_sane(report);
  EXPECT_EQ(report.at("notes").at("safety_fault"), "none");
  system.end_all();
}

}  // namespace
}  // namespace hapton::process
