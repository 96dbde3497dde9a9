// Objects that programs deform, in the loop of the haptics node: on simulated time, with a hub.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "haptics_node/reply_loop.h"
#include "link/known_shapes.h"
#include "link/shape_parts.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kShapeReachM = 0.02;
constexpr int kSkinSquares = 12;  // 169 vertices, sent in three parts
constexpr std::int32_t kSkinObject = 1;
const Vec3 kHandOverSkin(0.0061, 0.0043, 0.002);

using Displacements = std::vector<ShapePart::Displacement>;

Scene skin_scene() {
  Scene scene;
  SceneObject wall;
  wall.name = "wall";
  wall.mesh = made::shared(made::box(Vec3(0.2, -0.05, -0.02), Vec3(0.3, 0.05, 0.0)));
  scene.objects.push_back(wall);
  SceneObject skin;
  skin.name = "skin";
  skin.mesh = made::shared(made::sheet(0.03, 0.0, kSkinSquares));
  skin.program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = kShapeReachM});
  scene.objects.push_back(skin);
  return scene;
}

class ReplyLoopShapes : public ReplyLoopStage {
 protected:
  ReplyLoopShapes() {
    loop_.set_object_shaper(&shaper_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) cycle();
    cycle();
  }

  // Sends a sample, runs the loop once, receives at the hub for a millisecond, and does the work of the shaper's slow task.
  ForceCommand cycle(const Vec3& hand = kHandOverSkin) {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = hand});
    loop_.turn(clock_.now_ns() + kMs);
    order_.clear();
    receive_at_hub();
    while (runs_task_ && shaper_.work()) {
    }
    return force_;
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<ForceCommand>(&message)) force_ = *got;
    if (const auto* got = std::get_if<ShapeReply>(&message)) replies_.push_back(*got);
    if (const auto* got = std::get_if<ObjectShape>(&message)) {
      shapes_.push_back(*got);
      known_.take(*got, Arrival::newest);
    }
    if (const auto* got = std::get_if<ShapeStart>(&message)) {
      starts_.push_back(*got);
      known_.take(*got, Arrival::newest);
    }
    if (const auto* got = std::get_if<HapticsSetup>(&message)) rejection_ = got->rejection.data();
  }

  // A displacement for each vertex, which raises it by this height.
  Displacements raised(double height_m) const { return Displacements(mesh().vertices.size(), {0.0F, 0.0F, static_cast<float>(height_m)}); }
  const TriangleMesh& mesh() const { return *scene_.objects[kSkinObject].mesh; }
  // Sends the parts of a shape, except the part that begins with vertex `leave_out` (1: no part does).
  void send_shape(std::uint32_t shape, const Displacements& displacements, double over_s = 0.0, std::uint32_t stream = 7,
                  const char* object = "skin", std::uint32_t leave_out = 1) {
    ShapeRequest request{.stream = stream, .shape = shape, .over_s = over_s};
    put_text(object, request.object);
    for (std::uint32_t first = 0; first < displacements.size(); first += ShapePart::kVerticesPerPart) {
      if (first == leave_out) continue;
      request.part = make_shape_part(displacements, first);
      send(request);
    }
  }
  static void put_text(std::string_view text, ShapeText& into) {
    into = {};
    std::copy(text.begin(), text.end(), into.begin());
  }
  // Height of the announced surface under the hand, m; -1: no shape is known.
  double announced_height() const {
    const auto place = known_.find(kSkinObject, force_.scene_time_ns);
    return place ? static_cast<double>(known_.displacements_m(kSkinObject, *place)[0][2]) : -1.0;
  }

  Scene scene_ = skin_scene();
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene()), scene_.touch_scene()), 1e-5};
  MethodBuilder builder_{{}, scene_.touch_scene()};
  ObjectShaper shaper_{scene_, step_.touch(), 42};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  KnownShapes known_{{0, static_cast<std::uint32_t>(scene_.objects[kSkinObject].mesh->vertices.size())}};
  std::vector<ShapeReply> replies_;
  std::vector<ObjectShape> shapes_;
  std::vector<ShapeStart> starts_;
  std::string rejection_;
  ForceCommand force_;
  std::uint64_t sample_ = 0;
  bool runs_task_ = true;
};

// Each force is that of the announced shape at the scene time of its reply.
TEST_F(ReplyLoopShapes, ForcesAndTheAnnouncedShapesAgree) {
  ASSERT_TRUE(shaper_.has_objects());
  double largest_force_n = 0.0;
  double previous_force_n = 0.0;
  std::uint32_t shape = 0;
  for (int n = 0; n < 900; ++n) {
    if (n % 30 == 0) {
      ++shape;
      send_shape(shape, raised(shape % 3 == 0 ? -0.003 : 0.002 * (shape % 4)), 0.05);
    }
    const ForceCommand force = cycle();
    ASSERT_NEAR(force.force_n.z(), 1000.0 * std::max(0.0, announced_height() - kHandOverSkin.z()), 2e-3) << n;
    // A stiffness of 1000 N/m, a surface that moves at 0.25 m/s at most, and at most 2.1 ms from one sample to the next.
    ASSERT_LE(std::abs(force.force_n.z() - previous_force_n), 1000.0 * 0.25 * 0.0021) << n;
    previous_force_n = force.force_n.z();
    largest_force_n = std::max(largest_force_n, previous_force_n);
  }
  EXPECT_GT(largest_force_n, 3.0);
  EXPECT_GT(force_.shape_serial, 8U);
  EXPECT_EQ(force_.shape_serial, step_.counts().shapes_applied);
  for (const ShapeReply& reply : replies_) {
    EXPECT_STREQ(reply.rejection.data(), "");
    EXPECT_GE(reply.over_s, 0.05 - 1e-9);
  }
}

// The reference: the same shapes as keyframes of a scene, at the times that were announced.
TEST_F(ReplyLoopShapes, GivesTheForceOfTheSameShapesAsKeyframes) {
  constexpr std::uint64_t kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr std::uint32_t kShapes = MeshDeformation::kMaxTargets;
  std::vector<Displacements> sent_shapes;
  struct Cycle {
    Vec3 hand;
    ForceCommand force;
  };
  std::vector<Cycle> cycles;
  known_ = KnownShapes({0, 169});
  while (starts_.empty() || starts_.back().serial < kShapes || force_.scene_time_ns < starts_.back().end_ns + 20 * kMs) {
    ASSERT_LT(cycles.size(), 5000U);
    if (sent_shapes.size() < kShapes && cycles.size() % 60 == 0) {
      Displacements shape = raised(0.0);
      const Vec3 centre(0.02 * unit(random), 0.02 * unit(random), 0.0);
      const double height_m = 0.004 * unit(random);
      for (std::size_t v = 0; v < shape.size(); ++v) {
        const double r = std::min(1.0, (mesh().vertices[v] - centre).norm() / 0.03);
        shape[v] = {0.0F, 0.0F, static_cast<float>(height_m * (1.0 - r * r) * (1.0 - r * r))};
      }
      sent_shapes.push_back(shape);
      send_shape(static_cast<std::uint32_t>(sent_shapes.size()), shape, 0.04);
    }
    const double t = 2e-3 * static_cast<double>(cycles.size());
    const Vec3 hand(0.01 * std::sin(3.0 * t), 0.01 * std::cos(2.0 * t), 0.001 - 0.002 * std::sin(5.0 * t));
    cycle(hand);
    cycles.push_back({hand, force_});
  }
  ASSERT_EQ(step_.counts().shapes_applied, kShapes) << "none was left out";
  std::vector<MorphTarget> targets;
  std::vector<MorphKey> keys;
  const auto add_key = [&](std::int64_t at_ns, std::uint32_t shape) {
    keys.push_back({1e-9 * static_cast<double>(at_ns), std::vector<double>(kShapes, 0.0)});
    if (shape > 0) keys.back().weights[shape - 1] = 1.0;
  };
  for (const Displacements& shape : sent_shapes) {
    targets.emplace_back();
    for (std::uint32_t v = 0; v < shape.size(); ++v) {
      targets.back().vertices.push_back(v);
      targets.back().displacements.emplace_back(shape[v][0], shape[v][1], shape[v][2]);
    }
  }
  add_key(0, 0);
  std::uint32_t last_serial = 0;
  for (const ShapeStart& start : starts_) {
    if (start.serial <= last_serial) continue;  // the same start, announced again
    ASSERT_EQ(start.before, last_serial);
    if (1e-9 * static_cast<double>(start.start_ns) > keys.back().time_s) add_key(start.start_ns, start.before);
    add_key(start.end_ns, start.serial);
    last_serial = start.serial;
  }
  TouchScene keyframed_scene = scene_.touch_scene();
  keyframed_scene.objects[kSkinObject].stream_reach_m.reset();
  keyframed_scene.objects[kSkinObject].deformation = std::make_shared<const MeshDeformation>(targets, keys, false);
  auto method = make_method({}, keyframed_scene);
  ASSERT_TRUE(method) << method.error().what;
  TouchStep twin(std::move(*method), keyframed_scene);
  int contact_steps = 0;
  TouchInput input;
  for (std::size_t n = 0; n < cycles.size(); ++n) {
    input.p_WD = cycles[n].hand;
    input.time_s = 1e-9 * static_cast<double>(cycles[n].force.scene_time_ns);
    if (n == 0) twin.reset(input);
    const TouchOutput expected = twin.step(input);
    ASSERT_LT((cycles[n].force.force_n - expected.force_n).norm(), 1e-5 * (1.0 + expected.force_n.norm())) << "step " << n;
    ASSERT_LT((cycles[n].force.visual_offset_m - expected.visual_offset_m).norm(), 1e-8) << "step " << n;
    contact_steps += expected.contact ? 1 : 0;
  }
  EXPECT_GT(contact_steps, 200);
}

// A vision node has the whole shape and its times before the first force computed with it.
TEST_F(ReplyLoopShapes, TheShapeIsAnnouncedBeforeTheFirstForceWithIt) {
  send_shape(1, raised(0.005));
  std::size_t count_at_start = 0;
  std::vector<ForceCommand> forces;
  for (int n = 0; n < 60; ++n) {
    const bool was_known = std::any_of(starts_.begin(), starts_.end(), [](const ShapeStart& one) { return one.serial == 1; });
    forces.push_back(cycle());
    if (forces.back().shape_serial == 1 && count_at_start == 0) {
      count_at_start = forces.size();
      EXPECT_TRUE(was_known) << "in an earlier turn of the loop";
    }
  }
  ASSERT_GT(count_at_start, 0U);
  const auto start = std::find_if(starts_.begin(), starts_.end(), [](const ShapeStart& one) { return one.serial == 1; });
  EXPECT_LT(forces[count_at_start - 2].scene_time_ns, start->start_ns) << "a force already given does not change";
  ASSERT_EQ(shapes_.size(), 3U);
  EXPECT_EQ(shapes_[2].serial, 1U);
  ASSERT_EQ(replies_.size(), 1U);
  EXPECT_EQ(replies_[0].serial, 1U);
  EXPECT_NEAR(replies_[0].over_s, 0.005 / 0.25, 1e-6) << "slowed to the largest speed";
  EXPECT_NEAR(1e-9 * static_cast<double>(start->end_ns - start->start_ns), replies_[0].over_s, 1e-9);
}

TEST_F(ReplyLoopShapes, TheStartOfAShapeIsAnnouncedAgain) {
  send_shape(1, raised(0.005));
  for (int n = 0; n < 600; ++n) cycle();
  const auto announcements = [&] {
    return std::count_if(starts_.begin(), starts_.end(), [](const ShapeStart& one) { return one.serial == 1; });
  };
  EXPECT_GE(announcements(), 4) << "soon, a few times";
  starts_.clear();
  for (int n = 0; n < 2500; ++n) cycle();
  EXPECT_GE(announcements(), 1) << "once a second, for a node that joins later";
  EXPECT_LE(announcements(), 7);
}

TEST_F(ReplyLoopShapes, ANodeThatJoinsLateGetsTheNewestShape) {
  send_shape(1, raised(0.005));
  for (int n = 0; n < 100; ++n) cycle();
  shapes_.clear();
  send(ShapeStatus{.source = 42, .serial = 1, .object = kSkinObject, .first = 64});
  for (int n = 0; n < 10; ++n) cycle();
  ASSERT_EQ(shapes_.size(), 2U) << "only the parts that are missing";
  EXPECT_EQ(shapes_[0].part.first, 64U);
  EXPECT_EQ(shapes_[1].part.displacements_m[0], (ShapePart::Displacement{0.0F, 0.0F, 0.005F}));
  shapes_.clear();
  send(ShapeStatus{.source = 41, .serial = 1, .object = kSkinObject});
  send(ShapeStatus{.source = 42, .serial = 2, .object = kSkinObject});
  send(ShapeStatus{.source = 42, .serial = 1, .object = 0});
  for (int n = 0; n < 10; ++n) cycle();
  EXPECT_TRUE(shapes_.empty()) << "of another process, shape or object";
}

// A shape that lacks a part is left out; the next one is used.
TEST_F(ReplyLoopShapes, AShapeThatLostAPartIsLeftOut) {
  send_shape(1, raised(0.005), 0.0, 7, "skin", 64);
  for (int n = 0; n < 50; ++n) cycle();
  EXPECT_EQ(step_.counts().shapes_applied, 0U);
  send_shape(2, raised(0.004));
  send_shape(1, raised(0.005));  // all of its parts arrive, but after the newer shape
  for (int n = 0; n < 50; ++n) cycle();
  EXPECT_EQ(step_.counts().shapes_applied, 1U);
  EXPECT_EQ(shaper_.counts().incomplete, 1U);
  EXPECT_NEAR(announced_height(), 0.004, 1e-8);
}

// Of the shapes that arrive while the surface moves, only the newest is used.
TEST_F(ReplyLoopShapes, OnlyTheNewestWaitingShapeIsUsed) {
  send_shape(1, raised(0.005), 0.5);
  for (int n = 0; n < 20; ++n) cycle();
  for (std::uint32_t shape = 2; shape <= 6; ++shape) {
    send_shape(shape, raised(0.001 * shape), 0.01);
    cycle();
  }
  for (int n = 0; n < 1200; ++n) cycle();
  EXPECT_EQ(step_.counts().shapes_applied, 2U);
  EXPECT_NEAR(announced_height(), 0.006, 1e-8);
}

TEST_F(ReplyLoopShapes, AShapeThatIsRepeatedOnlyGetsItsReplyAgain) {
  send_shape(1, raised(0.005));
  for (int n = 0; n < 40; ++n) cycle();
  send_shape(1, raised(0.005));
  for (int n = 0; n < 40; ++n) cycle();
  EXPECT_EQ(replies_.size(), 2U);
  EXPECT_EQ(step_.counts().shapes_applied, 1U);
}

TEST_F(ReplyLoopShapes, AnImpossibleShapeIsRejectedInOneLine) {
  const auto expect_rejected = [&](const char* why) {
    for (int n = 0; n < 150; ++n) cycle();
    ASSERT_FALSE(replies_.empty()) << why;
    EXPECT_NE(std::string(replies_.back().rejection.data()).find(why), std::string::npos) << replies_.back().rejection.data();
    EXPECT_EQ(step_.counts().shapes_applied, 0U);
    replies_.clear();
  };
  send_shape(1, raised(0.001), 0.0, 7, "skim");
  expect_rejected("no object of the scene has that name");
  send_shape(1, raised(0.001), 0.0, 7, "wall");
  expect_rejected("programs may not deform this object");
  send_shape(1, Displacements(170), 0.0, 7);
  expect_rejected("another number of vertices");
  send_shape(1, raised(0.021), 0.0, 7);
  expect_rejected("the largest distance is the reach");
  Displacements folded = raised(0.0);
  folded[0] = {0.02F, 0.0F, 0.0F};  // the vertex moves into the middle of the sheet
  send_shape(2, folded, 0.0, 7);
  expect_rejected("at its end");
  send_shape(1, raised(0.001), 0.0, 9);
  expect_rejected("another program deforms this object");
  for (int n = 0; n < 1200; ++n) cycle();
  send_shape(1, raised(0.001), 0.0, 9);
  for (int n = 0; n < 40; ++n) cycle();
  EXPECT_EQ(step_.counts().shapes_applied, 1U) << "the first program is silent";
  EXPECT_NEAR(announced_height(), 0.001, 1e-8);
}

TEST_F(ReplyLoopShapes, TheMethodStays) {
  send(Settings{.method = {'r', 'e', 'f', 'e', 'r', 'e', 'n', 'c', 'e'}, .method_request = 3});
  for (int n = 0; n < 40; ++n) cycle();
  EXPECT_NE(rejection_.find("the method proxy"), std::string::npos);
  EXPECT_EQ(step_.counts().method_changes, 0U);
}

// However many parts arrive, the reply to a sample is sent first, few datagrams follow it, and the loop allocates no memory. Even shapes
// that jump as far as they are allowed to do not make the force jump.
TEST_F(ReplyLoopShapes, AFloodNeverComesBeforeAForce) {
  runs_task_ = false;
  std::uint32_t shape = 0;
  double previous_force_n = cycle().force_n.z();
  std::uint64_t allocations = 0;
  std::uint64_t datagrams = 0;
  for (int n = 0; n < 600; ++n) {
    for (int k = 0; k < 4; ++k) send_shape(++shape, raised((n / 50) % 2 == 0 ? 0.019 : -0.019), 0.0, 7);
    send_shape(shape, raised(0.0), 0.0, 8);
    send_shape(shape, raised(0.0), 0.0, 7, "nothing");
    send(ShapeStatus{.source = 42, .serial = step_.counts().shapes_applied > 0 ? force_.shape_serial : 1U, .object = kSkinObject});
    const std::uint64_t echoed = sample_ + 1;
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = kHandOverSkin});
    {
      const AllocationGuard guard;
      loop_.turn(clock_.now_ns() + kMs);
      allocations += guard.count();
    }
    order_.clear();
    receive_at_hub();
    datagrams += order_.size();
    (void)shaper_.work();
    ASSERT_EQ(force_.echo_sample, echoed);
    ASSERT_EQ(order_[0], Message(ForceCommand()).index()) << n;
    ASSERT_LE(order_.size(), 14U) << n;
    ASSERT_LE(std::abs(force_.force_n.z() - previous_force_n), 1000.0 * 0.25 * 0.0021) << n;
    previous_force_n = force_.force_n.z();
  }
  EXPECT_GT(step_.counts().shapes_applied, 4U);
  if (AllocationGuard::is_available()) {
    EXPECT_LT(allocations, datagrams + 60) << "the test's network keeps each datagram, and there is a log";
  }
}

TEST_F(ReplyLoopShapes, WithoutAShaperRequestsAreLeftOut) {
  loop_.set_object_shaper(nullptr);
  send_shape(1, raised(0.005));
  for (int n = 0; n < 20; ++n) cycle();
  EXPECT_TRUE(replies_.empty());
}

// The surface keeps its shape while materials change.
TEST_F(ReplyLoopShapes, MaterialsChangeUnderAShape) {
  send_shape(1, raised(0.005));
  for (int n = 0; n < 100; ++n) cycle();
  EXPECT_NEAR(force_.force_n.z(), 3.0, 1e-3);
  std::vector<Material> softer(2);
  softer[1].stiffness_n_per_m = 500.0;
  step_.set_materials(softer);
  for (int n = 0; n < 1200; ++n) cycle();
  EXPECT_NEAR(force_.force_n.z(), 1.5, 1e-3);
}

}  // namespace
}  // namespace hapton
