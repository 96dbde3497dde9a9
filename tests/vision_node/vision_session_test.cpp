#include "vision_node/vision_session.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "link/hub_peers.h"
#include "link/random_id.h"
#include "link/udp_endpoint.h"
#include "tests/vision_node/made_views.h"
#include "tests/vrpn/made_tracker.h"

// Last: it brings X's macros.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

// A hub that sends probe states at 500 Hz from a thread of its own and keeps what it receives.
class FakeHub {
 public:
  FakeHub() : endpoint_(std::move(*open_udp_endpoint("127.0.0.1:0"))), thread_([this] { run(); }) {}
  ~FakeHub() { stop(); }
  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Address address() const { return endpoint_->local_address(); }

  // Where the probe is, by sample; set before anyone joins.
  std::atomic<bool> moving{true};
  std::atomic<bool> contact{true};
  // Swallow this many view transforms, as a bad line would.
  std::atomic<int> lose_transforms{0};

  // To be looked at after stop().
  std::vector<ViewTransform> transforms;
  std::vector<FrameAck> drawn;
  std::vector<HandTarget> hands;
  std::uint64_t samples = 0;

 private:
  void run() {
    HubPeers peers(*endpoint_, clock_, make_random_id(), 500.0);
    Datagram received;
    ProbeState state;
    std::int64_t next_ns = clock_.now_ns();
    while (!stopping_) {
      next_ns += 2 * kNanosecondsPerMillisecond;
      while (clock_.now_ns() < next_ns) {
        if (peers.receive(received, next_ns).kind == PeerEvent::Kind::message) keep(received.message, state);
      }
      state.sample = ++samples;
      state.sample_time_ns = next_ns;
      if (moving) state.p_WD.x() = 0.05 * std::sin(0.01 * static_cast<double>(samples));
      state.contact = contact;
      state.object = contact ? 0 : -1;
      state.servo_rate_hz = 500.0F;
      peers.send_to_role(NodeRole::vision, state);
    }
  }

  void keep(const Message& message, ProbeState& state) {
    if (const auto* transform = std::get_if<ViewTransform>(&message)) {
      if (lose_transforms-- > 0) return;
      transforms.push_back(*transform);
      state.view_revision = transform->revision;
    }
    if (const auto* picture = std::get_if<FrameAck>(&message)) drawn.push_back(*picture);
    if (const auto* hand = std::get_if<HandTarget>(&message)) hands.push_back(*hand);
  }

  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

struct Session {
  explicit Session(const Address& hub, VisionOptions given = {}, bool shows_window = false,
                   std::shared_ptr<const TriangleMesh> mesh = make_marker(Vec3::Zero(), 0.03))
      : options(std::move(given)) {
    options.view.width_px = 320;
    options.view.height_px = 180;
    options.view.offscreen = !shows_window;
    if (options.seconds == 0.0) options.seconds = 1.2;
    Scene scene;
    scene.objects.push_back({"ball", std::move(mesh), {}, {0.8, 0.2, 0.1}});
    view = std::move(*open_view(scene, options));
    endpoint = std::move(*open_udp_endpoint("127.0.0.1:0"));
    client = std::make_unique<HubClient>(*endpoint, clock, NodeRole::vision, hub);
    session = std::make_unique<VisionSession>(*view, *client, clock, options);
  }

  VisionOptions options;
  SteadyClock clock;
  StopSignal stop;
  std::unique_ptr<StereoView> view;
  std::unique_ptr<Endpoint> endpoint;
  std::unique_ptr<HubClient> client;
  std::unique_ptr<VisionSession> session;
};

TEST(VisionSession, ShowsAnotherHandAndTurnsItsSceneToo) {
  FakeHub hub;
  FakeHub other_hub;
  hub.moving = false;
  VisionOptions options;
  options.dials_degrees = Vec3(0.0, 30.0, 0.0);
  Session vision(hub.address(), options);
  const auto endpoint = std::move(*open_udp_endpoint("127.0.0.1:0"));
  HubClient client(*endpoint, vision.clock, NodeRole::vision, other_hub.address());
  OtherHand other(client, Quat::Identity(), vision.options.rate_limit_hz);
  vision.session->set_other_hand(&other);
  ASSERT_TRUE(vision.session->run(vision.stop));
  vision.session.reset();
  hub.stop();
  other_hub.stop();
  ASSERT_GT(other_hub.drawn.size(), 3U);
  EXPECT_GT(other_hub.drawn.back().echo_sample, other_hub.samples / 2);
  std::size_t shown = 0;
  for (const FrameAck& drawn : other_hub.drawn) shown += drawn.unchanged ? 0 : 1;
  EXPECT_GT(shown, 3U) << "pictures for a hand that moves, though the first one rests";
  ASSERT_FALSE(other_hub.transforms.empty());
  EXPECT_EQ(other_hub.transforms.back().X_WS, hub.transforms.back().X_WS);
}

TEST(VisionSession, DrawsWhatMovesAndReportsEveryPicture) {
  FakeHub hub;
  Session vision(hub.address());
  ASSERT_TRUE(vision.session->run(vision.stop));
  vision.session.reset();
  hub.stop();
  ASSERT_GT(hub.drawn.size(), 3u);
  for (std::size_t i = 1; i < hub.drawn.size(); ++i) EXPECT_GE(hub.drawn[i].echo_sample, hub.drawn[i - 1].echo_sample);
  EXPECT_LE(hub.drawn.back().echo_sample, hub.samples);
  for (const FrameAck& drawn : hub.drawn) {
    if (drawn.unchanged) continue;
    EXPECT_GT(drawn.held_ns, 0U);
    EXPECT_LT(drawn.held_ns, 1e9);
  }
  EXPECT_GT(hub.drawn.back().echo_sample, hub.samples / 2) << "newest wins: pictures do not lag behind the hub";
}

// The tracker says one place, then nothing more: the picture is drawn for it, and stays so.
TEST(VisionSession, DrawsForATrackedHeadAndKeepsItWhenTheTrackerIsGone) {
  FakeHub hub;
  hub.moving = false;
  vrpn::MadeTracker tracker;
  std::atomic<bool> ends{false};
  std::thread speaks([&] {
    SteadyClock clock;
    const std::int64_t silent_ns = clock.now_ns() + 400 * kNanosecondsPerMillisecond;
    while (!ends) {
      tracker.attend();
      if (clock.now_ns() < silent_ns) tracker.say(vrpn::say_pose(0, {0.12, 0.05, 0.7}));
      clock.sleep_until_ns(clock.now_ns() + 5 * kNanosecondsPerMillisecond);
    }
  });
  VisionOptions options;
  options.head_source.tracker = vrpn::TrackerName{"Head0", to_string(tracker.address())};
  options.seconds = 1.5;
  Session vision(hub.address(), options);
  const auto head = std::move(*HeadTracker::open(options.head_source, 0.063));
  vision.session->set_head_tracker(head.get());
  const StereoScreen before = vision.view->screen();
  ASSERT_TRUE(vision.session->run(vision.stop));
  ends = true;
  speaks.join();
  const StereoScreen after = vision.view->screen();
  const double scale = before.distance_m / kDeskDistance;
  EXPECT_NEAR(after.distance_m, 0.7 * scale, 1e-9);
  EXPECT_LT((after.eyes_aside_m - scale * Vec2(0.12, 0.05)).norm(), 1e-9);
  EXPECT_NE(head->describe(vision.clock.now_ns()).find("it stays where it was"), std::string::npos);
}

TEST(VisionSession, RestsWhileNothingMoves) {
  FakeHub hub;
  hub.moving = false;
  Session vision(hub.address());
  ASSERT_TRUE(vision.session->run(vision.stop));
  EXPECT_LE(vision.session->step().frames().drawn(), 6u);
  EXPECT_GT(vision.session->step().frames().skipped_count(), 50u);
}

TEST(VisionSession, TheTwelveFloatsArriveThoughTheFirstAreLost) {
  FakeHub hub;
  hub.lose_transforms = 2;
  VisionOptions options;
  options.dials_degrees = {10.0, -20.0, 30.0};
  Session vision(hub.address(), options);
  ASSERT_TRUE(vision.session->run(vision.stop));
  hub.stop();
  Dials dials;
  for (int axis = 0; axis < 3; ++axis) dials.turn(axis, options.dials_degrees[axis]);
  ASSERT_FALSE(hub.transforms.empty());
  EXPECT_LE(hub.transforms.size(), 3u) << "not again once the hub has them";
  EXPECT_EQ(hub.transforms.back().X_WS, to_twelve_floats(dials.compute_pose(Vec3::Zero())));
}

TEST(VisionSession, ScreenshotShowsTheContactOrElseTheEnd) {
  const auto file = std::filesystem::temp_directory_path() / ("hapton_session_" + std::to_string(getpid()) + ".png");
  for (const bool contact : {true, false}) {
    std::filesystem::remove(file);
    FakeHub hub;
    hub.contact = contact;
    VisionOptions options;
    options.screenshot = file;
    Session vision(hub.address(), options);
    ASSERT_TRUE(vision.session->run(vision.stop));
    EXPECT_TRUE(std::filesystem::exists(file)) << contact;
  }
  std::filesystem::remove(file);
}

TEST(VisionSession, WithoutAHubItStillDrawsAndEndsInTime) {
  auto nobody = *open_udp_endpoint("127.0.0.1:0");
  VisionOptions options;
  options.seconds = 0.3;
  Session vision(nobody->local_address(), options);
  const std::int64_t begin = vision.clock.now_ns();
  ASSERT_TRUE(vision.session->run(vision.stop));
  EXPECT_GE(vision.clock.now_ns() - begin, 300 * kNanosecondsPerMillisecond);
  EXPECT_GE(vision.session->step().frames().drawn(), 1u);
}

TEST(VisionSession, OutlivesTheHubAndFindsTheNextOne) {
  auto hub = std::make_unique<FakeHub>();
  const Address address = hub->address();
  VisionOptions options;
  options.seconds = 3.0;
  Session vision(address, options);
  std::thread person([&] {
    vision.clock.sleep_until_ns(vision.clock.now_ns() + 800 * kNanosecondsPerMillisecond);
    hub.reset();
  });
  ASSERT_TRUE(vision.session->run(vision.stop));
  person.join();
  EXPECT_EQ(vision.client->state(), JoinState::joining);
  EXPECT_EQ(vision.client->counts().joins, 1u);
}

TEST(VisionSession, TheMouseLeadsTheHandToTheSurfaceUnderItAndKeysChangeThePicture) {
  FakeHub hub;
  hub.moving = false;
  VisionOptions options;
  options.seconds = 2.5;
  options.view_yaw_deg = options.view_pitch_deg = 0.0;
  options.view_mm = 64.0;  // the ball fills it: the hand is led a hundredth of that within
  Session vision(hub.address(), options, true);
  vision.view->draw();
  const double zoomed_out_m = vision.view->screen().width_m;
  std::thread hands([&vision] {
    Person person;
    const auto wait = [&vision](int ms) { vision.clock.sleep_until_ns(vision.clock.now_ns() + ms * kNanosecondsPerMillisecond); };
    wait(800);
    person.move(160, 90);
    person.button(ButtonPress, 1, 160, 90);
    wait(300);
    person.button(ButtonRelease, 1, 160, 90);
    person.press_key(XK_plus, ShiftMask);
    person.press_key(XK_m);
  });
  ASSERT_TRUE(vision.session->run(vision.stop));
  hands.join();
  vision.session.reset();
  hub.stop();
  const auto led = std::find_if(hub.hands.begin(), hub.hands.end(), [](const HandTarget& hand) { return hand.active; });
  ASSERT_NE(led, hub.hands.end());
  // The ball's surface in front of its middle is 30 mm from it; the hand is a little within.
  EXPECT_LT(led->p_WH.norm(), 0.0302);
  EXPECT_GT(led->p_WH.norm(), 0.028);
  EXPECT_GT(led->p_WH.z(), 0.027);
  EXPECT_FALSE(hub.hands.back().active) << "and was released";
  EXPECT_EQ(vision.view->mode(), StereoMode::side_by_side);
  EXPECT_LT(vision.view->screen().width_m, zoomed_out_m);
}

TEST(VisionSession, AtRestTheSceneComesToFullDetailByItself) {
  auto nobody = *open_udp_endpoint("127.0.0.1:0");
  VisionOptions options;
  options.seconds = 4.0;
  const auto mesh = std::make_shared<TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  Session vision(nobody->local_address(), options, false, mesh);
  ASSERT_TRUE(vision.session->run(vision.stop));
  ASSERT_EQ(vision.view->detail_progress(), 1.0);
  EXPECT_LT(vision.view->paint_count().triangles, mesh->triangles.size()) << "a coarser level would do while it moves";
  for (int part = 0; part < 3; ++part) EXPECT_FALSE(vision.view->refine()) << "nothing is left to do";
}

TEST(FrameScene, HoldsTheWholeSceneWhateverTheDialsDo) {
  Scene scene;
  scene.objects.push_back({"far", make_marker({0.1, 0.0, 0.0}, 0.02), {}, {}});
  const Framing framing = frame_scene(scene, {});
  EXPECT_GT(framing.view_m, 2.0 * 0.12);
  EXPECT_EQ(framing.p_WC, Vec3::Zero());
}

TEST(RateLimit, IsLowerWhereTheCpuDraws) {
  VisionOptions options;
  EXPECT_EQ(choose_rate_limit(options, "NVIDIA GeForce"), 60.0);
  EXPECT_EQ(choose_rate_limit(options, "llvmpipe (LLVM 15.0.6, 256 bits)"), 30.0);
  options.rate_limit_hz = 0.0;
  EXPECT_EQ(choose_rate_limit(options, "llvmpipe"), 0.0);
}

}  // namespace
}  // namespace hapton
