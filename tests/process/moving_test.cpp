// Objects that move by keyframes or deform, in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "link/known_shapes.h"
#include "link/shape_outbox.h"
#include "scene/touch_mesh.h"
#include "tests/process/trajectory_session.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// A hand that holds still over the piston of scenes/machine.toml is pushed up by it; the recording gives the same forces again.
TEST(MovingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n60,-0.068,0.033,0\n", "machine.toml");
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// A hand that holds still over the block of scenes/deforming.toml is pushed up by its first hump.
TEST(DeformingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.0543,0,-0.006\n0.5,-0.0543,-0.030,-0.006\n60,-0.0543,-0.030,-0.006\n",
                            "deforming.toml");
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

Ended move_with(const TrajectorySession& session, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "move");
  arguments.insert(arguments.end(), {"--hub", session.hub});
  return run("hapton", arguments, session.scratch.path()).value_or(Ended{});
}

// Tries until the move succeeds: the programs may still be starting, or the machine may stop for seconds.
Ended move_when_ready(const TrajectorySession& session, const std::vector<std::string>& arguments) {
  Ended moved;
  System::wait_until([&] {
    moved = move_with(session, arguments);
    return moved.exit_code == 0;
  });
  EXPECT_EQ(moved.exit_code, 0) << moved.err;
  return moved;
}

// A hand that holds still over the platform of scenes/lift.toml is pushed up when a program lifts it.
TEST(ObjectsThatProgramsMove, PushAHandThatHoldsStillAndAreReplayed) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.05,0.06,0.01\n0.5,-0.05,0.029,0.01\n600,-0.05,0.029,0.01\n", "lift.toml");
  const Ended moved = move_when_ready(session, {"platform", "--to", "-0.05,-0.005,0", "--over", "0.2"});
  EXPECT_EQ(moved.out, "platform moves, for 0.200 s\n");
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  const Ended slowed = move_when_ready(session, {"platform", "--to", "-0.05,-0.02,0", "--over", "0.01"});
  EXPECT_THAT(slowed.out, HasSubstr(" s, not 0.01 s: no point of it may be faster than 0.25 m/s\n"));
  move_when_ready(session, {"#2", "--rotate", "-90,0,70"});
  Ended rejected;
  const auto is_refused = [&] {
    rejected = move_with(session, {"ground", "--to", "0,0,0"});
    return rejected.err.find("rejected") != std::string::npos;
  };
  EXPECT_TRUE(System::wait_until(is_refused));
  EXPECT_EQ(rejected.exit_code, 1);
  EXPECT_EQ(
      rejected.err,
      "hapton move: the haptics node rejected it: programs may not move 'ground': give it moved_by = \"program\" in the scene file\n");
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  const Ended info = run("hapton", {"session", "info", session.file}, session.scratch.path()).value_or(Ended{});
  EXPECT_THAT(info.out, HasSubstr("objects moved by programs: "));
}

// A program that joins the hub beside the nodes, in this role.
struct Companion {
  Companion(const TrajectorySession& session, KeyRole key_role, NodeRole role)
      : at(*parse_address(session.hub)),
        endpoint(*open_udp_endpoint("127.0.0.1:0")),
        sealed(*endpoint, clock, RoleKey(*find_or_make_shared_key(session.scratch.path() / "hapton"), key_role), at),
        client(sealed, clock, role, at) {}

  SteadyClock clock;
  Address at;
  std::unique_ptr<Endpoint> endpoint;
  SealedClient sealed;
  HubClient client;
};

using Displacements = std::vector<ShapePart::Displacement>;

// The shape in which the middle of the top of the block of scenes/swelling.toml is height_m higher.
Displacements swelling_of(const TriangleMesh& block, double height_m) {
  Displacements shape;
  for (const Vec3& p : block.vertices) {
    const double r = std::min(1.0, std::hypot(p.x(), p.y()) / 0.03);
    shape.push_back({0.0F, 0.0F, static_cast<float>(height_m * std::pow(1.0 - r * r, 2) * std::max(0.0, p.z() / 0.02))});
  }
  return shape;
}

// A hand that holds still over the block of scenes/swelling.toml is pushed up when a program raises its top, and again by a stream of
// shapes. A node that joins later gets the shape, and the recording gives the same forces again.
TEST(ObjectsThatProgramsDeform, PushAHandThatHoldsStillAndAreReplayed) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,0,0.06,0\n0.5,0,0.034,0\n600,0,0.034,0\n", "swelling.toml");
  const auto block = load_touch_mesh(HAPTON_SOURCE_DIR "/meshes/supple_block.obj", Unit::mm, CrackSealing::off);
  ASSERT_TRUE(block) << block.error().what;
  const Displacements raised = swelling_of(block->mesh, 0.012);
  Companion program(session, KeyRole::tool, NodeRole::tool);
  ShapeOutbox outbox;
  const double patience_s = kPatience.count();
  const auto duration_s = deform_object(program.client, program.clock, outbox, "block", raised, 0.2, patience_s);
  ASSERT_TRUE(duration_s) << duration_s.error().what;
  EXPECT_NEAR(*duration_s, 0.2, 1e-6);
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));

  Companion late(session, KeyRole::vision, NodeRole::vision);
  KnownShapes known({static_cast<std::uint32_t>(raised.size())});
  const auto knows = [&](const Displacements& shape) {
    Datagram datagram;
    while (late.client.receive(datagram, late.clock.now_ns() + kNanosecondsPerMillisecond)) {
      if (const auto* part = std::get_if<ObjectShape>(&datagram.message)) known.take(*part, late.client.last_arrival());
      if (const auto* start = std::get_if<ShapeStart>(&datagram.message)) known.take(*start, late.client.last_arrival());
      if (const auto* state = std::get_if<ProbeState>(&datagram.message)) {
        late.client.send(FrameAck{.echo_sample = state->sample, .echo_sample_time_ns = state->sample_time_ns});
      }
      if (const auto request = known.take_request(late.clock.now_ns())) late.client.send(*request);
      const auto place = known.find(0, std::numeric_limits<std::int64_t>::max() / 2);
      if (place && known.displacements_m(0, *place) == shape) return true;
    }
    return false;
  };
  EXPECT_TRUE(System::wait_until([&] { return knows(raised); })) << "joined after the shape";

  for (int n = 0; n < 60; ++n) {
    ASSERT_TRUE(outbox.give("block", swelling_of(block->mesh, 0.012 * std::cos(0.2 * n)), 1.0 / 30.0));
    const std::int64_t next_ns = program.clock.now_ns() + 33 * kNanosecondsPerMillisecond;
    Datagram datagram;
    while (program.clock.now_ns() < next_ns) {
      outbox.send(program.client, program.clock.now_ns());
      if (program.client.receive(datagram, program.clock.now_ns() + kNanosecondsPerMillisecond)) outbox.take(datagram.message);
    }
  }
  const Displacements at_rest(raised.size());
  const auto back_s = deform_object(program.client, program.clock, outbox, "block", at_rest, 0.0, patience_s);
  ASSERT_TRUE(back_s) << back_s.error().what;
  EXPECT_TRUE(System::wait_until([&] { return knows(at_rest); }));
  const auto rejected = deform_object(program.client, program.clock, outbox, "fish", at_rest, 0.0, patience_s);
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, HasSubstr("no object of the scene has that name"));
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
  EXPECT_EQ(replayed.out.find("the recording does not have"), std::string::npos) << replayed.out;
  const Ended info = run("hapton", {"session", "info", session.file}, session.scratch.path()).value_or(Ended{});
  EXPECT_THAT(info.out, HasSubstr("shapes of objects from programs: "));
}

// The same if io_node computes the force itself: it uses the shapes that it relays.
TEST(ObjectsThatProgramsDeform, PushAHandAlsoWhereIoNodeComputesTheForce) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,0,0.06,0\n0.5,0,0.034,0\n600,0,0.034,0\n", "swelling.toml",
                            {"--touch", "patch"});
  const auto block = load_touch_mesh(HAPTON_SOURCE_DIR "/meshes/supple_block.obj", Unit::mm, CrackSealing::off);
  ASSERT_TRUE(block) << block.error().what;
  EXPECT_TRUE(System::wait_until([&] { return session.read_counter("local_forces") > 100; }));
  EXPECT_EQ(session.read_counter("shapes_late"), 0);
  Companion program(session, KeyRole::tool, NodeRole::tool);
  ShapeOutbox outbox;
  const auto duration_s =
      deform_object(program.client, program.clock, outbox, "block", swelling_of(block->mesh, 0.012), 0.2, kPatience.count());
  ASSERT_TRUE(duration_s) << duration_s.error().what;
  const std::int64_t before = session.read_counter("local_forces");
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  EXPECT_TRUE(System::wait_until([&] { return session.read_counter("local_forces") > before; })) << "io_node still computes the force";
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// A hand pushes the brick of scenes/push.toml from its left side by 30 mm. The brick moves with it, and a replay gives the same forces.
TEST(ObjectsThatArePushed, GoWhereTheHandPushesThemAndAreReplayed) {
  TrajectorySession session(
      "simulated", "t_s,x_m,y_m,z_m\n0,-0.005,0.018,0\n0.5,-0.005,-0.008,0\n1,0.0095,-0.008,0\n2.5,0.04,-0.008,0\n600,0.04,-0.008,0\n",
      "push.toml");
  Program dynamics("hapton", {"dynamics", "--scene", HAPTON_SOURCE_DIR "/scenes/push.toml", "--hub", session.hub}, session.scratch.path());
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.3));
  // Runs until the push is over: the simulated hand does not wait for this program.
  EXPECT_FALSE(dynamics.wait(Seconds(4))) << dynamics.out() << dynamics.err();
  dynamics.send_signal(SIGTERM);
  const auto ended = dynamics.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("bodies: brick (0.15 kg), peg (0.1 kg), wing nut (0.08 kg); obstacles: 1\n"));
  std::smatch moved;
  ASSERT_TRUE(std::regex_search(ended->out, moved, std::regex("brick is ([0-9.]+) mm from where it began"))) << ended->out;
  EXPECT_NEAR(std::stod(moved[1]), 30.0, 6.0);
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// Waits for this many forces from patches, then for the push. The recording has the forces of the haptics node, 20 a second.
void expect_pushed_from_patches(TrajectorySession& session, std::int64_t forces) {
  EXPECT_TRUE(System::wait_until([&] { return session.io.out().find("hub on ") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return session.read_counter("local_forces") > forces; })) << session.haptics.err();
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  EXPECT_EQ(session.haptics.err().find("this node computes the forces"), std::string::npos) << session.haptics.err();
  session.end();
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

// The same if io_node computes the force from patches: the piston pushes the hand.
TEST(MovingObjects, PushAHandThatFeelsThemFromPatches) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n600,-0.068,0.033,0\n", "machine.toml",
                            {"--touch", "patch"});
  expect_pushed_from_patches(session, 2000);
}

// A block that heaves. The fish of scenes/deforming.toml would keep the force remote, because of its bumps.
TEST(DeformingObjects, PushAHandThatFeelsThemFromPatches) {
  const ScratchFolder folder;
  const std::string scene = (folder.path() / "heaving.toml").string();
  std::ofstream(scene) << "[[object]]\nname = \"block\"\nmesh = \"" HAPTON_SOURCE_DIR
                          "/meshes/supple_block.obj\"\nunit = \"mm\"\nrotation_deg = [-90, 0, 0]\nloop = true\n"
                          "[[object.morph]]\npush_m = [0, 0, 0.012]\ncenter_m = [-0.045, 0.005, 0.02]\nradius_m = 0.035\n"
                          "keys = [[0.0, 0.0], [0.8, 1.0], [1.6, 0.0]]\n";
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.045,0.06,-0.005\n0.5,-0.045,0.025,-0.005\n600,-0.045,0.025,-0.005\n", scene,
                            {"--touch", "patch"});
  expect_pushed_from_patches(session, 3000);
}

// A program lifts the platform under a hand that feels it from patches, and softens it meanwhile.
TEST(ObjectsThatProgramsMove, PushAHandThatFeelsThemFromPatches) {
  TrajectorySession session("simulated", "t_s,x_m,y_m,z_m\n0,-0.05,0.06,0.01\n0.5,-0.05,0.029,0.01\n600,-0.05,0.029,0.01\n", "lift.toml",
                            {"--touch", "patch"});
  EXPECT_TRUE(System::wait_until([&] { return session.io.out().find("hub on ") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return session.read_counter("local_forces") > 1000; })) << session.haptics.err();
  move_when_ready(session, {"platform", "--to", "-0.05,-0.005,0", "--over", "0.2"});
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  const std::int64_t before = session.read_counter("local_forces");
  const auto set = run("hapton", {"set", "--hub", session.hub, "--object", "platform", "--stiffness", "300"}, session.scratch.path());
  ASSERT_TRUE(set);
  EXPECT_EQ(set->exit_code, 0) << set->err;
  EXPECT_TRUE(System::wait_until([&] { return session.read_counter("local_forces") > before + 1000; })) << "patches go on";
  session.end();
}

}  // namespace
}  // namespace hapton::process
