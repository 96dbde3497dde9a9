#include "vision_node/vision_session.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iterator>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "link/hub_peers.h"
#include "link/random_id.h"
#include "link/udp_endpoint.h"
#include "tests/support/log_of.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/gone_folder.h"
#include "tests/vision_node/made_views.h"
#include "tests/vrpn/made_tracker.h"

// Include this last: it brings X's macros, which break other headers.
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

  // Whether the probe moves with the samples, and whether it touches object 0. Set them before a node joins.
  std::atomic<bool> moves_probe{true};
  std::atomic<bool> touches_object{true};
  // After the first acknowledgement of a frame, the hub sends no more states.
  std::atomic<bool> ends_with_first_ack{false};
  // Number of view transforms that the hub ignores, as if a bad network had lost them.
  std::atomic<int> transforms_to_lose{0};

  // Read these only after stop().
  std::vector<ViewTransform> transforms;
  std::vector<FrameAck> acks;
  std::vector<HandTarget> hand_targets;
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
        if (peers.receive(received, next_ns).kind == PeerEvent::Kind::message) store(received.message, state);
      }
      if (ends_with_first_ack && !acks.empty()) continue;
      state.sample = ++samples;
      state.sample_time_ns = next_ns;
      if (moves_probe) state.p_WD.x() = 0.05 * std::sin(0.01 * static_cast<double>(samples));
      state.contact = touches_object;
      state.object = touches_object ? 0 : -1;
      state.servo_rate_hz = 500.0F;
      peers.send_to_role(NodeRole::vision, state);
    }
  }

  void store(const Message& message, ProbeState& state) {
    if (const auto* transform = std::get_if<ViewTransform>(&message)) {
      if (transforms_to_lose-- > 0) return;
      transforms.push_back(*transform);
      state.view_revision = transform->revision;
    }
    if (const auto* ack = std::get_if<FrameAck>(&message)) acks.push_back(*ack);
    if (const auto* hand = std::get_if<HandTarget>(&message)) hand_targets.push_back(*hand);
  }

  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

struct Session {
  explicit Session(const Address& hub, VisionOptions base_options = {}, bool shows_window = false,
                   std::shared_ptr<const TriangleMesh> mesh = make_marker(Vec3::Zero(), 0.03))
      : options(std::move(base_options)) {
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

// Runs a check that waits a short time, and if it fails, repeats it with times that are 4 and 16 times as long: on a machine that stalls,
// a second may be too short. check gets that factor.
template <class Check>
void expect_with_retries(Check&& check) {
  testing::AssertionResult result = check(1.0);
  for (const double time_factor : {4.0, 16.0}) {
    if (!result) result = check(time_factor);
  }
  EXPECT_TRUE(result);
}
#define HAPTON_FAIL_UNLESS(condition) \
  if (!(condition)) return testing::AssertionFailure() << #condition << ' '

testing::AssertionResult shows_another_hand(double time_factor) {
  FakeHub hub;
  FakeHub other_hub;
  hub.moves_probe = false;
  VisionOptions options;
  options.seconds = 1.2 * time_factor;
  options.dials_degrees = Vec3(0.0, 30.0, 0.0);
  Session vision(hub.address(), options);
  const auto endpoint = std::move(*open_udp_endpoint("127.0.0.1:0"));
  HubClient client(*endpoint, vision.clock, NodeRole::vision, other_hub.address());
  OtherHand other(client, Quat::Identity(), vision.options.rate_limit_hz);
  vision.session->set_other_hand(&other);
  HAPTON_FAIL_UNLESS(vision.session->run(vision.stop));
  vision.session.reset();
  hub.stop();
  other_hub.stop();
  HAPTON_FAIL_UNLESS(other_hub.acks.size() > 3U) << other_hub.acks.size();
  HAPTON_FAIL_UNLESS(other_hub.acks.back().echo_sample > other_hub.samples / 2) << other_hub.acks.back().echo_sample;
  std::size_t shown = 0;
  for (const FrameAck& ack : other_hub.acks) shown += ack.unchanged ? 0 : 1;
  HAPTON_FAIL_UNLESS(shown > 3U) << "pictures for a hand that moves, though the first one rests";
  HAPTON_FAIL_UNLESS(!other_hub.transforms.empty() && !hub.transforms.empty());
  HAPTON_FAIL_UNLESS(other_hub.transforms.back().X_WS == hub.transforms.back().X_WS);
  return testing::AssertionSuccess();
}

TEST(VisionSession, ShowsAnotherHandAndTurnsItsSceneToo) { expect_with_retries(shows_another_hand); }

testing::AssertionResult draws_what_moves(double time_factor) {
  FakeHub hub;
  VisionOptions options;
  options.seconds = 1.2 * time_factor;
  Session vision(hub.address(), options);
  HAPTON_FAIL_UNLESS(vision.session->run(vision.stop));
  vision.session.reset();
  hub.stop();
  HAPTON_FAIL_UNLESS(hub.acks.size() > 3u) << hub.acks.size();
  for (std::size_t i = 1; i < hub.acks.size(); ++i) EXPECT_GE(hub.acks[i].echo_sample, hub.acks[i - 1].echo_sample);
  EXPECT_LE(hub.acks.back().echo_sample, hub.samples);
  for (const FrameAck& ack : hub.acks) {
    if (ack.unchanged) continue;
    EXPECT_GT(ack.held_ns, 0U);
    HAPTON_FAIL_UNLESS(ack.held_ns < 1e9) << ack.held_ns;
  }
  HAPTON_FAIL_UNLESS(hub.acks.back().echo_sample > hub.samples / 2) << "newest wins: pictures do not lag behind the hub";
  return testing::AssertionSuccess();
}

TEST(VisionSession, DrawsWhatMovesAndReportsEveryPicture) { expect_with_retries(draws_what_moves); }

// Later frames, which are drawn for other reasons, show the same state: its age in them is not a latency.
testing::AssertionResult acknowledges_each_state_once(double time_factor) {
  FakeHub hub;
  hub.ends_with_first_ack = true;
  VisionOptions options;
  options.seconds = 1.2 * time_factor;
  options.plots = true;  // plots are drawn again and again
  Session vision(hub.address(), options);
  HAPTON_FAIL_UNLESS(vision.session->run(vision.stop));
  const std::uint64_t frames = vision.session->step().frames().drawn();
  vision.session.reset();
  hub.stop();
  std::vector<FrameAck> measured;
  std::copy_if(hub.acks.begin(), hub.acks.end(), std::back_inserter(measured), [](const FrameAck& ack) { return !ack.unchanged; });
  for (std::size_t i = 1; i < measured.size(); ++i) EXPECT_GT(measured[i].echo_sample, measured[i - 1].echo_sample);
  HAPTON_FAIL_UNLESS(!measured.empty() && frames > measured.size() + 3) << frames << " " << measured.size();
  HAPTON_FAIL_UNLESS(hub.acks.back().unchanged) << "the hub may not have got the first";
  EXPECT_EQ(hub.acks.back().held_ns, 0U);
  return testing::AssertionSuccess();
}

TEST(VisionSession, AcknowledgesEachStateOnceHoweverOftenItIsDrawn) { expect_with_retries(acknowledges_each_state_once); }

// The tracker sends one position for a while, then nothing: the picture is drawn for a head at that position, and stays so.
testing::AssertionResult draws_for_a_tracked_head(double time_factor) {
  FakeHub hub;
  hub.moves_probe = false;
  vrpn::MadeTracker tracker;
  std::atomic<bool> ends{false};
  std::thread server([&] {
    SteadyClock clock;
    const std::int64_t silent_from_ns = clock.now_ns() + static_cast<std::int64_t>(4e8 * time_factor);
    while (!ends) {
      tracker.poll();
      if (clock.now_ns() < silent_from_ns) tracker.say(vrpn::say_pose(0, {0.12, 0.05, 0.7}));
      clock.sleep_until_ns(clock.now_ns() + 5 * kNanosecondsPerMillisecond);
    }
  });
  VisionOptions options;
  options.head_source.tracker = vrpn::TrackerName{"Head0", to_string(tracker.address())};
  options.seconds = 1.5 * time_factor;
  Session vision(hub.address(), options);
  const auto head = std::move(*HeadTracker::open(options.head_source, 0.063));
  vision.session->set_head_tracker(head.get());
  const StereoScreen before = vision.view->screen();
  const bool has_run = vision.session->run(vision.stop).has_value();
  ends = true;
  server.join();
  HAPTON_FAIL_UNLESS(has_run);
  const StereoScreen after = vision.view->screen();
  const double scale = before.distance_m / kDeskDistance;
  HAPTON_FAIL_UNLESS(std::abs(after.distance_m - 0.7 * scale) < 1e-9) << after.distance_m;
  HAPTON_FAIL_UNLESS((after.eyes_offset_m - scale * Vec2(0.12, 0.05)).norm() < 1e-9) << after.eyes_offset_m.transpose();
  const std::string description = head->describe(vision.clock.now_ns());
  HAPTON_FAIL_UNLESS(description.find("the head stays where it was") != std::string::npos) << description;
  return testing::AssertionSuccess();
}

TEST(VisionSession, DrawsForATrackedHeadAndKeepsItWhenTheTrackerIsGone) { expect_with_retries(draws_for_a_tracked_head); }

testing::AssertionResult rests_while_nothing_moves(double time_factor) {
  FakeHub hub;
  hub.moves_probe = false;
  VisionOptions options;
  options.seconds = 1.2 * time_factor;
  Session vision(hub.address(), options);
  HAPTON_FAIL_UNLESS(vision.session->run(vision.stop));
  HAPTON_FAIL_UNLESS(vision.session->step().frames().drawn() <= 6u) << vision.session->step().frames().drawn();
  HAPTON_FAIL_UNLESS(vision.session->step().frames().skipped() > 50u) << vision.session->step().frames().skipped();
  return testing::AssertionSuccess();
}

TEST(VisionSession, RestsWhileNothingMoves) { expect_with_retries(rests_while_nothing_moves); }

TEST(VisionSession, TheTwelveFloatsArriveThoughTheFirstAreLost) {
  FakeHub hub;
  hub.transforms_to_lose = 2;
  VisionOptions options;
  options.dials_degrees = {10.0, -20.0, 30.0};
  options.seconds = 3.0;
  Session vision(hub.address(), options);
  ASSERT_TRUE(vision.session->run(vision.stop));
  hub.stop();
  Dials dials;
  for (int axis = 0; axis < 3; ++axis) dials.turn(axis, options.dials_degrees[axis]);
  ASSERT_FALSE(hub.transforms.empty());
  EXPECT_LE(hub.transforms.size(), 3u) << "not again once the hub has them";
  EXPECT_EQ(hub.transforms.back().X_WS, to_twelve_floats(dials.compute_pose(Vec3::Zero())));
}

// A picture of the contact is written while the session goes on: here it would go on for minutes, and ends once there is a picture.
TEST(VisionSession, ScreenshotShowsTheContactOrElseTheEnd) {
  const ScratchFolder folder;
  for (const bool contact : {true, false}) {
    FakeHub hub;
    hub.touches_object = contact;
    VisionOptions options;
    options.screenshot = folder.path() / (contact ? "contact.png" : "end.png");
    if (contact) options.seconds = 300.0;
    Session vision(hub.address(), options);
    std::atomic<bool> has_ended{false};
    bool is_taken_during_session = false;
    std::thread person([&] {
      is_taken_during_session = wait_until([&] { return has_ended || std::filesystem::exists(options.screenshot); }) && !has_ended;
      if (contact) vision.stop.request_stop();
    });
    Result<void> ended;
    const std::string log = log_of([&] { ended = vision.session->run(vision.stop); });
    has_ended = true;
    person.join();
    ASSERT_TRUE(ended);
    EXPECT_TRUE(std::filesystem::exists(options.screenshot)) << contact;
    EXPECT_TRUE(is_taken_during_session || !contact) << log;
    EXPECT_EQ(log.find("shows no contact: ") == std::string::npos, contact) << log;
  }
}

TEST(VisionSession, WithoutAHubItStillDrawsAndEndsInTime) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  VisionOptions options;
  options.seconds = 0.3;
  Session vision(silent_endpoint->local_address(), options);
  const std::int64_t begin = vision.clock.now_ns();
  ASSERT_TRUE(vision.session->run(vision.stop));
  EXPECT_GE(vision.clock.now_ns() - begin, 300 * kNanosecondsPerMillisecond);
  EXPECT_GE(vision.session->step().frames().drawn(), 1u);
}

// Before the session runs, a person has drawn a dot on the ball.
struct DrawnDot {
  explicit DrawnDot(Session& vision) {
    scene.objects.push_back({"ball", make_marker(Vec3::Zero(), 0.03), {}, {}});
    options.file = folder.path() / "notes.toml";
    annotator = std::move(*Annotator::open(*vision.view, scene, 0.03, options, true));
    vision.session->set_annotator(annotator.get());
    ProbeState state;
    state.p_WD = Vec3(0.0, 0.0, 0.03);
    state.contact = true;
    state.object = 0;
    for (const std::uint32_t buttons : {0U, 2U, 0U}) {
      state.buttons = buttons;
      annotator->receive(state, Pose::Identity());
    }
  }

  ScratchFolder folder;
  Scene scene;
  AnnotatorOptions options;
  std::unique_ptr<Annotator> annotator;
};

VisionOptions with_impossible_screenshot(const char* moment) {
  VisionOptions options;
  options.seconds = 0.3;
  options.screenshot = "/nowhere/a.png";
  options.screenshot_moment = *ScreenshotMoment::parse(moment);
  return options;
}

TEST(VisionSession, WhatIsDrawnIsSavedThoughTheScreenshotFails) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  for (const char* moment : {"0", "exit"}) {
    Session vision(silent_endpoint->local_address(), with_impossible_screenshot(moment));
    const DrawnDot dot(vision);
    const auto ended = vision.session->run(vision.stop);
    ASSERT_FALSE(ended) << moment;
    EXPECT_NE(ended.error().what.find("/nowhere/a.png"), std::string::npos) << ended.error().what;
    EXPECT_TRUE(std::filesystem::exists(dot.options.file)) << moment;
  }
}

TEST(VisionSession, AScreenshotAndADrawingThatCannotBeWrittenAreBothReported) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  Session vision(silent_endpoint->local_address(), with_impossible_screenshot("exit"));
  const DrawnDot dot(vision);
  std::filesystem::create_directory(dot.options.file);  // instead of the file, which cannot be written then
  Result<void> ended;
  const std::string log = log_of([&] { ended = vision.session->run(vision.stop); });
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().what.find("/nowhere/a.png"), std::string::npos) << ended.error().what;
  EXPECT_NE(log.find(dot.options.file.string()), std::string::npos) << log;
}

TEST(VisionSession, AScreenshotByKeyThatFailsIsALineInThePicture) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  VisionOptions options;
  options.seconds = 30.0;  // the key q ends it earlier
  Session vision(silent_endpoint->local_address(), options, true);
  vision.view->draw();
  Person person;
  ASSERT_TRUE(person.has_window());
  for (const KeySym key : {XK_s, XK_q}) person.press_key(key);
  const GoneFolder nowhere;
  const auto ended = vision.session->run(vision.stop);
  ASSERT_TRUE(ended) << ended.error().what;
  const std::string& line = vision.session->step().recent_event();
  EXPECT_TRUE(line.starts_with("NO SCREENSHOT: cannot write the screenshot hapton_001.png")) << line;
}

testing::AssertionResult outlives_the_hub(double time_factor) {
  auto hub = std::make_unique<FakeHub>();
  const Address address = hub->address();
  VisionOptions options;
  options.seconds = 3.0 * time_factor;
  Session vision(address, options);
  std::thread hub_ender([&] {
    vision.clock.sleep_until_ns(vision.clock.now_ns() + static_cast<std::int64_t>(8e8 * time_factor));
    hub.reset();
  });
  const bool has_run = vision.session->run(vision.stop).has_value();
  hub_ender.join();
  HAPTON_FAIL_UNLESS(has_run);
  HAPTON_FAIL_UNLESS(vision.client->state() == JoinState::joining);
  HAPTON_FAIL_UNLESS(vision.client->counts().joins == 1u) << vision.client->counts().joins;
  return testing::AssertionSuccess();
}

TEST(VisionSession, OutlivesTheHubAndFindsTheNextOne) { expect_with_retries(outlives_the_hub); }

testing::AssertionResult the_mouse_leads_the_hand(double time_factor) {
  FakeHub hub;
  hub.moves_probe = false;
  VisionOptions options;
  options.seconds = 2.5 * time_factor;
  options.view_yaw_deg = options.view_pitch_deg = 0.0;
  options.view_mm = 64.0;  // the ball almost fills this view; the hand is led 1 % of the view below the surface
  Session vision(hub.address(), options, true);
  vision.view->draw();
  const double width_before_zoom_m = vision.view->screen().width_m;
  std::thread user([&vision, time_factor] {
    Person person;
    const auto wait = [&](double ms) {
      vision.clock.sleep_until_ns(vision.clock.now_ns() + static_cast<std::int64_t>(1e6 * ms * time_factor));
    };
    wait(800);
    person.move_pointer(160, 90);
    person.send_button(ButtonPress, 1, 160, 90);
    wait(300);
    person.send_button(ButtonRelease, 1, 160, 90);
    person.press_key(XK_plus, ShiftMask);
    person.press_key(XK_m);
  });
  const bool has_run = vision.session->run(vision.stop).has_value();
  user.join();
  HAPTON_FAIL_UNLESS(has_run);
  vision.session.reset();
  hub.stop();
  const auto led = std::find_if(hub.hand_targets.begin(), hub.hand_targets.end(), [](const HandTarget& hand) { return hand.active; });
  HAPTON_FAIL_UNLESS(led != hub.hand_targets.end());
  // The surface is 30 mm from the ball's centre, towards the viewer; the hand is led to a point slightly below it.
  EXPECT_LT(led->p_WH.norm(), 0.0302);
  EXPECT_GT(led->p_WH.norm(), 0.028);
  EXPECT_GT(led->p_WH.z(), 0.027);
  HAPTON_FAIL_UNLESS(!hub.hand_targets.back().active) << "and was released";
  HAPTON_FAIL_UNLESS(vision.view->mode() == StereoMode::side_by_side);
  HAPTON_FAIL_UNLESS(vision.view->screen().width_m < width_before_zoom_m);
  return testing::AssertionSuccess();
}

TEST(VisionSession, TheMouseLeadsTheHandToTheSurfaceUnderItAndKeysChangeThePicture) { expect_with_retries(the_mouse_leads_the_hand); }

testing::AssertionResult comes_to_full_detail(double time_factor) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  VisionOptions options;
  options.seconds = 4.0 * time_factor;
  const auto mesh = std::make_shared<TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 20'000, 1));
  Session vision(silent_endpoint->local_address(), options, false, mesh);
  HAPTON_FAIL_UNLESS(vision.session->run(vision.stop));
  HAPTON_FAIL_UNLESS(vision.view->detail_progress() == 1.0) << vision.view->detail_progress();
  EXPECT_LT(vision.view->paint_count().triangles, mesh->triangles.size()) << "a coarser level would do while it moves";
  for (int part = 0; part < 3; ++part) HAPTON_FAIL_UNLESS(!vision.view->refine()) << "nothing is left to do";
  return testing::AssertionSuccess();
}

TEST(VisionSession, AtRestTheSceneComesToFullDetailByItself) { expect_with_retries(comes_to_full_detail); }

TEST(VisionSession, SaysInThePictureThatTheSavedSceneFileHasAnError) {
  auto silent_endpoint = *open_udp_endpoint("127.0.0.1:0");
  const ScratchFolder folder;
  folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const std::string object = "[[object]]\nmesh = 'a.obj'\n";
  const auto file = folder.write("a.toml", object);
  VisionOptions options;
  options.seconds = 0.3;
  Session vision(silent_endpoint->local_address(), options);
  auto scene = load_scene(file, {});
  ASSERT_TRUE(scene) << scene.error().what;
  LiveScene live(*vision.view, vision.options, std::move(*scene));
  SceneReload reload(file, {});
  live.watch(&reload);
  vision.session->set_live_scene(&live);
  const auto save_and_run = [&](const std::string& keys) {
    folder.write("a.toml", object + keys);
    reload.poll();
    reload.poll();
    EXPECT_TRUE(vision.session->run(vision.stop));
    return vision.session->step().scene_problem();
  };
  EXPECT_NE(save_and_run("colr = [1, 0, 0]\n").find("unknown key 'colr'"), std::string::npos) << vision.session->step().scene_problem();
  EXPECT_EQ(save_and_run("color = [1, 0, 0] # red\n"), "");
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
