#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "devices/model_a.h"
#include "haptic_step/object_mover.h"
#include "haptics_node/grasp_task.h"
#include "haptics_node/new_scene.h"
#include "haptics_node/object_shaper.h"
#include "haptics_node/patch_sender.h"
#include "haptics_node/reply_loop.h"
#include "io_node/local_patch.h"
#include "io_node/network_loop.h"
#include "io_node/patch_link.h"
#include "io_node/patch_thread.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "scene/scene_file.h"
#include "scene/tool_obstacles.h"
#include "tests/faults/simulated_network.h"
#include "tests/support/made_meshes.h"

namespace hapton {

// A clock driven by another one, with a settable offset.
class ShiftedClock final : public Clock {
 public:
  explicit ShiftedClock(const Clock& base) : base_(base) {}
  std::int64_t now_ns() const noexcept override { return base_.now_ns() + shift_ns_; }
  void sleep_until_ns(std::int64_t) noexcept override {}
  void step_ns(std::int64_t by_ns) noexcept { shift_ns_ += by_ns; }

 private:
  const Clock& base_;
  std::int64_t shift_ns_ = 0;
};

// A device that moves along -z onto the face z = 0.05 m of a box, 0.1 m wide around the origin, in its first 100 ms, and then stays 2 mm
// inside it, oscillating along x by a millimetre. Frame W. It records the forces on its motors.
class PressingDevice final : public Device {
 public:
  struct Written {
    Vec3 force_n;
    std::int64_t time_ns;
  };

  std::string_view name() const noexcept override { return "pressing"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    if (begin_ns_ == 0) begin_ns_ = now_ns;
    if (target) {
      const Vec3 left = *target - position_m_;
      position_m_ += left.norm() <= target_step_m ? left : Vec3(left.normalized() * target_step_m);
      return {now_ns, position_m_, Quat::Identity(), buttons};
    }
    const double share = std::min(1.0, 1e-8 * static_cast<double>(now_ns - begin_ns_));
    const double x_m = 0.01 + 0.001 * std::sin(1e-9 * static_cast<double>(now_ns - begin_ns_));
    position_m_ = Vec3(x_m, 0.02, 0.06 - 0.012 * share);
    return {now_ns, position_m_, Quat::Identity(), buttons};
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override { written.push_back({wrench.force_n, now_ns}); }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

  std::vector<Written> written;
  std::optional<Vec3> target;   // if set, the device moves there instead
  double target_step_m = 5e-5;  // by at most this in each sample
  std::uint32_t buttons = 0;

 private:
  DeviceLimits limits_ = model_a::limits();
  Vec3 position_m_ = Vec3::Zero();
  std::int64_t begin_ns_ = 0;
};

// One haptics node: its clock, its sealed connection to the hub and its loop.
class SimulatedHaptics {
 public:
  // scene: felt by method `proxy`; no objects: a box, 0.1 m wide, around the origin. builds_on_approach: as in ReplyLoop, the first reply
  // waits until the builder's thread, in real time, has built the objects nearby.
  SimulatedHaptics(SimulatedNetwork& network, const SimulatedClock& time, const LinkKey& key, const Address& hub, const Address& at,
                   const SealedClient::Options& sealing = {}, const Scene& scene = {}, bool builds_on_approach = false)
      : clock(time),
        mover(scene, 77),
        network_(network),
        at_(at),
        endpoint_(network.open_node(at, [this] { turn(); })),
        sealed_(*endpoint_, clock, RoleKey(key, KeyRole::haptics), hub, sealing),
        client_(sealed_, clock, NodeRole::haptics, hub),
        touch_scene_(scene.objects.empty() ? box() : scene.touch_scene()),
        step_(std::make_unique<TouchStep>(*make_method(settings(), touch_scene_), touch_scene_), 1e-5),
        builder_(settings(), touch_scene_),
        loop_(client_, clock, step_, builder_, {.method = {"name=proxy"}}, builds_on_approach),
        patches_(touch_scene_, 0.0, 1, true) {
    loop_.set_patch_sender(&patches_);
    if (!scene.objects.empty()) loop_.set_object_mover(&mover);
    if (touch_scene_.has_streamed()) {
      loop_.set_object_shaper(&shaper_.emplace(scene, step_.touch(), 77U));
      shaper_->start();
    }
    const auto movable = list_movable(scene);
    if (std::find(movable.begin(), movable.end(), true) == movable.end()) return;
    step_.set_grasp(&grasp_.emplace(grasp_link_, movable, 1U), make_tool_obstacles(touch_scene_).parts);
    material_task_.emplace(scene, 0.0);
    const auto on_scene = [this](const TouchScene& now, std::uint32_t revision) { patches_.set_scene(now, 0, revision); };
    grasp_task_.emplace(GraspTask::Options{.on_scene = on_scene}, scene, std::vector<PutDown>(), grasp_link_, *material_task_, builder_,
                        real_clock_);
    grasp_task_->start();
  }
  ~SimulatedHaptics() { network_.kill(at_); }
  SimulatedHaptics(const SimulatedHaptics&) = delete;
  SimulatedHaptics& operator=(const SimulatedHaptics&) = delete;

  const HubClient& client() const { return client_; }
  std::uint64_t sessions() const { return sealed_.seal_counts().handshakes; }
  const Address& address() const { return at_; }
  std::int64_t scene_time_ns() const { return step_.scene_time_ns(); }
  const TouchStep& touch() const { return step_.touch(); }
  // Pre: the scene has movable objects.
  const Grasp& grasp() const { return *grasp_; }
  // Requests a shape of the first object, as a program does. Pre: programs may deform it.
  void deform(std::uint32_t shape, const std::vector<ShapePart::Displacement>& displacements_m, double over_s) {
    for (std::uint32_t first = 0; first < displacements_m.size(); first += ShapePart::kVerticesPerPart) {
      shaper_->accept({.stream = 1, .shape = shape, .over_s = over_s, .part = make_shape_part(displacements_m, first)}, clock.now_ns());
    }
  }
  const ObjectShaper& shaper() const { return *shaper_; }
  // Sets the scene, as the file watcher of the node does when the scene's file was saved again.
  void set_scene(const Scene& scene) {
    touch_scene_ = scene.touch_scene();
    const auto made = make_new_scene(scene, 0.0, ++revision_, false);
    const auto built = builder_.rebuild_for(made);
    EXPECT_TRUE(built) << built.error().what;
    patches_.set_scene(touch_scene_, made->hash);
  }
  // Sets materials, as the node's MaterialTask does when it accepts a request.
  void set_materials(const std::vector<Material>& materials) {
    step_.set_materials(materials);
    patches_.set_materials(materials);
  }

  ShiftedClock clock;
  ObjectMover mover;  // for requests of programs

 private:
  static MethodSettings settings() { return {.name = "proxy"}; }
  static TouchScene box() { return {.objects = {{made::shared(made::box(Vec3::Constant(-0.05), Vec3::Constant(0.05))), {}}}}; }

  void turn() {
    // During construction the network delivers nothing to this node.
    loop_.turn(clock.now_ns());
  }

  SimulatedNetwork& network_;
  Address at_;
  std::unique_ptr<Endpoint> endpoint_;
  SealedClient sealed_;
  HubClient client_;
  TouchScene touch_scene_;
  HapticsStep step_;
  MethodBuilder builder_;
  ReplyLoop loop_;
  PatchSender patches_;
  std::optional<ObjectShaper> shaper_;
  std::uint32_t revision_ = 0;
  SteadyClock real_clock_;
  GraspLink grasp_link_;
  std::optional<Grasp> grasp_;
  std::optional<MaterialTask> material_task_;
  std::optional<GraspTask> grasp_task_;
};

// A vision node that sends acks_per_state acknowledgements of each state, and a HandTarget with each but the first.
class SimulatedVision {
 public:
  SimulatedVision(SimulatedNetwork& network, const SimulatedClock& time, const LinkKey& key, const Address& hub, const Address& at,
                  int acks_per_state)
      : network_(network),
        clock_(time),
        at_(at),
        acks_per_state_(acks_per_state),
        endpoint_(network.open_node(at, [this] { turn(); })),
        sealed_(*endpoint_, time, RoleKey(key, KeyRole::vision), hub),
        client_(sealed_, time, NodeRole::vision, hub) {}
  ~SimulatedVision() { network_.kill(at_); }
  SimulatedVision(const SimulatedVision&) = delete;
  SimulatedVision& operator=(const SimulatedVision&) = delete;

  const Address& address() const { return at_; }
  int received_states() const { return received_states_; }
  void send(const Message& message) { client_.send(message); }

 private:
  void turn() {
    Datagram datagram;
    while (client_.receive(datagram, clock_.now_ns())) {
      const auto* state = std::get_if<ProbeState>(&datagram.message);
      if (state == nullptr) continue;
      ++received_states_;
      for (int n = 0; n < acks_per_state_; ++n) {
        client_.send(FrameAck{state->sample, state->sample_time_ns, 60.0F, 1000});
        if (n > 0) client_.send(HandTarget{});
      }
    }
  }

  SimulatedNetwork& network_;
  const SimulatedClock& clock_;
  Address at_;
  int acks_per_state_;
  std::unique_ptr<Endpoint> endpoint_;
  SealedClient sealed_;
  HubClient client_;
  int received_states_ = 0;
};

// The hub with device side and network side, and a haptics node over a network with given faults; all product code, except for the clock.
class SimulatedSystem {
 public:
  static constexpr std::int64_t kMs = 1'000'000;
  static constexpr std::int64_t kWireNs = 30'000;  // one direction without faults

  explicit SimulatedSystem(std::uint64_t seed = 1, TouchChoice touch = TouchChoice::remote, double rate_hz = 1000.0)
      : network(clock, seed), touch_(touch), rate_hz_(rate_hz) {
    set_faults({}, {});
    start_hub();
  }

  // The faults of each direction, in addition to the delay kWireNs.
  void set_faults(LinkFaults to_hub, LinkFaults to_nodes) {
    to_hub.delay_ns += kWireNs;
    to_nodes.delay_ns += kWireNs;
    network.set_faults(to_hub, to_nodes);
  }

  // Starts the hub, or restarts it as a new session at the same address.
  void start_hub() {
    network_loop.reset();
    peers_.reset();
    sealed_.emplace(*hub_endpoint_, clock, key_);
    peers_.emplace(*sealed_, clock, ++session_, rate_hz_);
    network_loop = std::make_unique<NetworkLoop>(device, *peers_, clock, NetworkLoop::Options{.rate_hz = rate_hz_});
    if (touch_ == TouchChoice::remote) return;
    patch_link_.reset();
    patch_thread_.reset();
    local_ = std::make_unique<LocalPatch>();
    patch_thread_ = std::make_unique<PatchThread>(*local_);
    patch_link_ = std::make_unique<PatchLink>(*peers_, *local_, *patch_thread_, touch_);
    touch_recorder_.emplace(*local_, local_steps);
    network_loop->device_loop().set_local_touch(&*touch_recorder_);
    network_loop->set_patch_link(patch_link_.get());
  }

  void start_haptics(const SealedClient::Options& sealing = {}) {
    Address at{{}, next_port_++};
    at.ip = hub_address_.ip;
    haptics = std::make_unique<SimulatedHaptics>(network, clock, key_, hub_address_, at, sealing, scene, builds_on_approach);
  }
  std::unique_ptr<SimulatedVision> make_vision(int acks_per_state) {
    Address at{{}, next_port_++};
    at.ip = hub_address_.ip;
    return std::make_unique<SimulatedVision>(network, clock, key_, hub_address_, at, acks_per_state);
  }
  // Like kill -9: without a goodbye.
  void kill_haptics() {
    network.kill(haptics->address());
    haptics.reset();
  }

  // A vision node joins, sends the view and leaves.
  void send_view(const ViewTransform& view) {
    const auto vision = make_vision(1);
    run_for_ns(100 * kMs);
    vision->send(view);
    run_for_ns(100 * kMs);
  }
  // Runs until the condition holds, which may depend on threads in real time. False: not within 30 s of real time.
  template <class Condition>
  bool wait_until(Condition&& holds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < deadline) {
      run_for_ns(5 * kMs);
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  // Runs until the force comes from patches. False: not within the time of wait_until.
  bool wait_for_patches() {
    std::uint64_t before = stats().local_forces;
    return wait_until([&] { return stats().local_forces > std::exchange(before, stats().local_forces) + 3; });
  }

  void run_for_ns(std::int64_t duration_ns) {
    const std::int64_t end_ns = clock.now_ns() + duration_ns;
    while (clock.now_ns() < end_ns) network_loop->step();
  }

  // As run_for_ns, but pauses in real time every 5 ms, so that the threads that send and build patches keep up on a busy machine: for 1 ms,
  // or for longer if they are late.
  void run_slowly_for_ns(std::int64_t duration_ns) {
    const std::int64_t end_ns = clock.now_ns() + duration_ns;
    while (clock.now_ns() < end_ns) {
      run_for_ns(5 * kMs);
      const bool is_late = !local_steps.empty() && local_steps.back().is_beyond;
      std::this_thread::sleep_for(std::chrono::milliseconds(is_late ? 20 : 1));
    }
  }

  bool wants_patches() const { return patch_link_ != nullptr && patch_link_->is_wanted(); }
  const LinkKey& key() const { return key_; }
  const ServoStats& stats() { return network_loop->collect_stats(); }
  Vec3 force_n() const { return device.written.empty() ? Vec3(Vec3::Zero()) : device.written.back().force_n; }

  // The time since which all written forces are zero; none: the newest one is not zero, or no force was written.
  std::optional<std::int64_t> zero_since_ns() const {
    std::optional<std::int64_t> zero_since;
    for (const auto& written : device.written) {
      if (written.force_n != Vec3::Zero())
        zero_since.reset();
      else if (!zero_since)
        zero_since = written.time_ns;
    }
    return zero_since;
  }
  // The time of the first force at or after time_ns that is not zero; none: there is no such force.
  std::optional<std::int64_t> force_after_ns(std::int64_t time_ns) const {
    for (const auto& written : device.written) {
      if (written.time_ns >= time_ns && written.force_n != Vec3::Zero()) return written.time_ns;
    }
    return std::nullopt;
  }

  // A force that the hub computed from patches, and its sample. is_beyond: the sample is past the edge of the hub's patches, and the next
  // patch is not there yet; on a busy machine the threads that send and build it may be late.
  struct LocalStep {
    DeviceSample sample;
    LocalForce force;
    bool is_beyond = false;
  };

  SimulatedClock clock{
      100'000'000'000'000'000};  // 3.2 years: later than this machine's CLOCK_MONOTONIC, which threads that build patches read
  SimulatedNetwork network;
  PressingDevice device;
  std::unique_ptr<NetworkLoop> network_loop;
  std::unique_ptr<SimulatedHaptics> haptics;
  Scene scene;                      // of haptics nodes that are started from now on; no objects: a box
  bool builds_on_approach = false;  // likewise
  std::vector<LocalStep> local_steps;

 private:
  class LocalTouchRecorder final : public LocalTouch {
   public:
    LocalTouchRecorder(LocalPatch& local, std::vector<LocalStep>& local_steps) : local_(local), local_steps_(local_steps) {}
    std::optional<LocalForce> step(const DeviceSample& sample) noexcept override {
      const std::optional<LocalForce> force = local_.step(sample);
      const std::uint64_t before = std::exchange(beyond_steps_, local_.counts().beyond_steps);
      if (force) local_steps_.push_back({sample, *force, beyond_steps_ > before});
      return force;
    }

   private:
    LocalPatch& local_;
    std::vector<LocalStep>& local_steps_;
    std::uint64_t beyond_steps_ = 0;
  };

  LinkKey key_ = LinkKey::make_random();
  Address hub_address_{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1}, 4950};
  std::unique_ptr<Endpoint> hub_endpoint_ = network.open_hub(hub_address_);
  std::optional<SealedHub> sealed_;
  std::optional<HubPeers> peers_;
  std::uint64_t session_ = 100;
  std::uint16_t next_port_ = 5001;
  TouchChoice touch_;
  double rate_hz_;
  std::unique_ptr<LocalPatch> local_;
  std::optional<LocalTouchRecorder> touch_recorder_;
  std::unique_ptr<PatchThread> patch_thread_;
  std::unique_ptr<PatchLink> patch_link_;
};

}  // namespace hapton
