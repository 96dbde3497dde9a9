#include "tools/demo/demo_system.h"

#include "core/geometry/mesh_shapes.h"
#include "runtime/atomic_file.h"
#include "scene/find_scene.h"
#include "scene/scene_file.h"
#include "tools/child_process.h"
#include "tools/demo/demo_shapes.h"
#include "tools/session/ply_writer.h"

namespace hapton {
namespace {

// Servo rate of the tour: a cycle takes 1 ms.
constexpr const char* kRateHz = "1000";

// Writes the mesh that is too large to be shipped, and a scene file for it.
Result<std::filesystem::path> write_heavy_scene(const std::filesystem::path& folder) {
  constexpr std::uint64_t kSeed = 1;
  const auto mesh =
      make_rough_sphere(demo_heavy::kRadiusM, demo_heavy::kCurvatureRadiusM, demo_heavy::kWavelengthM, demo_heavy::kTriangles, kSeed);
  if (const auto written = write_ply(folder / "heavy.ply", mesh); !written) return tl::unexpected(written.error());
  const auto scene = folder / "heavy.toml";
  const auto written =
      write_file_atomically(scene, "[[object]]\nname = \"ball\"\nmesh = \"heavy.ply\"\nunit = \"m\"\ncolor = [0.55, 0.62, 0.50]\n");
  return written ? Result<std::filesystem::path>(scene) : tl::unexpected(written.error());
}

}  // namespace

Result<void> DemoSystem::prepare(const DemoStep& step) {
  if (step.scene.empty()) {
    const auto heavy = write_heavy_scene(settings_.scratch);
    if (!heavy) return tl::unexpected(heavy.error());
    scene_ = *heavy;
  } else {
    scene_ = find_scene(step.scene);
  }
  const auto scene = load_scene(scene_, {.sealing = CrackSealing::off});
  if (!scene) return tl::unexpected(scene.error());
  const auto path = step.make_path(*scene);
  if (!path) return tl::unexpected(path.error());
  const auto hub = find_free_address();
  if (!hub) return tl::unexpected(hub.error());
  hub_ = nodes_hub_ = *hub;
  return write_file_atomically(settings_.scratch / "path.csv", positions_to_csv(*path));
}

Result<void> DemoSystem::start_hub() {
  std::vector<std::string> words = {"--bind",
                                    hub_,
                                    "--rate",
                                    kRateHz,
                                    "--device",
                                    "simulated",
                                    "--trajectory",
                                    (settings_.scratch / "path.csv").string(),
                                    "--loop",
                                    "--cpu",
                                    fmt::format("{}", settings_.cpu),
                                    "--spin-reply",
                                    "0",  // the haptics node is on the same CPU
                                    "--out",
                                    settings_.out.string(),
                                    "--flight",
                                    "off"};
  if (settings_.records) words.insert(words.end(), {"--record", recording().string()});
  auto io = LocalNode::start(settings_.out, "io_node", find_own_folder() / "io_node", std::move(words));
  if (!io) return tl::unexpected(io.error());
  io_.emplace(std::move(*io));
  return io_->wait_for("hub on ");
}

// `hapton relay` imitates a network between the haptics node and the hub, with the flags of the step.
Result<void> DemoSystem::start_relay(const DemoStep& step) {
  std::vector<std::string> words = {"--seed", "1"};
  words.insert(words.end(), step.relay.begin(), step.relay.end());
  auto relay = start_local_relay(settings_.out, hub_, words);
  if (!relay) return tl::unexpected(relay.error());
  relay_.emplace(std::move(relay->node));
  nodes_hub_ = relay->address;
  return {};
}

Result<void> DemoSystem::start_haptics() {
  // --build-at-once: the structures of the objects are built before the hand comes near them, not while it does.
  auto haptics = LocalNode::start(
      settings_.out, "haptics_node", find_own_folder() / "haptics_node",
      {"--hub", nodes_hub_, "--scene", scene_.string(), "--build-at-once", "--cpu", fmt::format("{}", settings_.cpu), "--spin", "0"});
  if (!haptics) return tl::unexpected(haptics.error());
  haptics_.emplace(std::move(*haptics));
  return haptics_->wait_for("ready");
}

Result<void> DemoSystem::start(const DemoStep& step) {
  if (const auto prepared = prepare(step); !prepared) return prepared;
  if (const auto started = step.relay.empty() ? Result<void>() : start_relay(step); !started) return started;
  // The haptics node is ready before the hub and its simulated hand start, because a hand that is
  // inside a body before there is a method feels nothing until it has left.
  if (const auto started = start_haptics(); !started) return started;
  return start_hub();
}

// The vision node connects to the hub directly: a relay is only between the hub and the haptics node.
Result<void> DemoSystem::start_vision(const DemoStep& step) {
  std::vector<std::string> words = {"--hub", hub_, "--scene", scene_.string()};
  words.insert(words.end(), step.vision.begin(), step.vision.end());
  words.insert(words.end(), settings_.vision.begin(), settings_.vision.end());
  auto vision = LocalNode::start(settings_.out, "vision_node", find_own_folder() / "vision_node", std::move(words));
  if (!vision) return tl::unexpected(vision.error());
  vision_.emplace(std::move(*vision));
  return {};
}

void DemoSystem::kill_haptics() {
  haptics_->kill();
  haptics_.reset();
}

Result<void> DemoSystem::check_running() {
  for (auto* node : {&io_, &relay_, &haptics_, &vision_}) {
    if (!node->has_value()) continue;
    if (const auto running = (*node)->check_running(); !running) return running;
  }
  return {};
}

bool DemoSystem::is_vision_open() { return vision_.has_value() && vision_->check_running().has_value(); }

Result<void> DemoSystem::stop() {
  Result<void> ended;
  for (auto* node : {&vision_, &haptics_, &io_, &relay_}) {
    if (!node->has_value()) continue;
    if (const auto stopped = (*node)->stop(); !stopped && ended) ended = stopped;
    node->reset();
  }
  return ended;
}

}  // namespace hapton
