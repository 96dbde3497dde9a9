#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "hid/hidapi_transport.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "runtime/descriptor_check.h"
#include "runtime/instruction_set_check.h"
#include "runtime/log.h"
#include "runtime/standard_streams.h"
#include "runtime/stop_signal.h"
#include "runtime/writable_path.h"
#include "scene/find_scene.h"
#include "scene/scene_file.h"
#include "vision_node/live_scene.h"
#include "vision_node/scene_reload.h"
#include "vision_node/show_recording.h"
#include "vision_node/vision_options.h"
#include "vision_node/vision_session.h"
#include "vision_node/xr/headset_show.h"

namespace {

using namespace hapton;

int give_up(const Error& error) {
  log_error("{}", error.what);
  return 1;
}

// Reports an invalid command line, and returns the exit code for it.
int reject_options(const Error& error) {
  log_error("{}", error.what);
  return 2;
}

// Checks this before anything is shown: at the end it would be too late to choose another file.
Result<void> check_screenshot(const std::filesystem::path& file) {
  if (file.empty()) return {};
  if (file.extension() != ".png" && file.extension() != ".PNG") {
    return fail("--screenshot {}: pictures are written as PNG; give it a name that ends in .png", file.string());
  }
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return fail("--screenshot {}: cannot be written: {}; name a folder that exists and is writable", file.string(), std::strerror(errno));
  }
  if (const auto writable = check_writable_file(file); !writable) return fail("--screenshot {}", writable.error().what);
  return {};
}

// The connection to the hub of another hand.
struct OtherLink {
  OtherLink(std::unique_ptr<Endpoint> socket, const Clock& clock, const RoleKey& key, const Address& hub, const VisionOptions& options)
      : endpoint(std::move(socket)),
        sealed(*endpoint, clock, key, hub),
        client(sealed, clock, NodeRole::vision, hub),
        hand(client, make_lean(options.stylus_lean_deg * std::numbers::pi / 180.0), options.rate_limit_hz) {}

  std::unique_ptr<Endpoint> endpoint;
  SealedClient sealed;
  HubClient client;
  OtherHand hand;
};

// Null if no other hand is to be shown.
Result<std::unique_ptr<OtherLink>> open_other_link(const VisionOptions& options, const Clock& clock) {
  if (options.other_hub.empty()) return std::unique_ptr<OtherLink>();
  const auto hub = parse_address(options.other_hub);
  if (!hub) return tl::unexpected(hub.error());
  const auto key = find_role_key(options.key_file, *hub, KeyRole::vision);
  if (!key) return tl::unexpected(key.error());
  auto endpoint = open_udp_endpoint(any_address_like(*hub));
  if (!endpoint) return tl::unexpected(endpoint.error());
  return std::make_unique<OtherLink>(std::move(*endpoint), clock, *key, *hub, options);
}

// Null if no head tracker was asked for.
Result<std::unique_ptr<HeadTracker>> open_head_tracker(const VisionOptions& options) {
  if (!options.head_source.tracker) return std::unique_ptr<HeadTracker>();
  return HeadTracker::open(options.head_source, 1e-3 * options.ipd_mm);
}

// Null if no headset was asked for.
Result<std::unique_ptr<Headset>> connect_headset(const VisionOptions& options) {
  if (options.view.stereo != StereoMode::openxr) return std::unique_ptr<Headset>();
  return Headset::connect();
}

// Null if there is no headset.
Result<std::unique_ptr<HeadsetShow>> open_headset(std::unique_ptr<Headset> headset, StereoView& view, const VisionOptions& options) {
  if (headset == nullptr) return std::unique_ptr<HeadsetShow>();
  return HeadsetShow::open(std::move(headset), view, options.room, options.X_OW);
}

auto find_drawn_tool(const VisionOptions& options, const Scene& scene) {
  std::vector<std::string> notes;
  auto tool = find_tool(options.tool, scene, options.loading, notes);
  for (const auto& note : notes) {
    if (tool) log_info("tool: {}", note);
  }
  return tool;
}

// What is shown, and where.
struct OpenedWindow {
  Scene scene;
  std::optional<SceneTool> tool;
  std::unique_ptr<StereoView> view;
};

// Reads scene and tool, and opens the window on them.
Result<OpenedWindow> open_window(const std::filesystem::path& scene_path, VisionOptions& options) {
  auto scene = load_scene(scene_path, options.loading);
  if (!scene) return tl::unexpected(scene.error());
  for (const auto& note : scene->notes) log_info("{}", note);
  auto tool = find_drawn_tool(options, *scene);
  if (!tool) return tl::unexpected(tool.error());
  auto view = open_view(*scene, options);
  if (!view) return tl::unexpected(view.error());
  if (*tool) (*view)->set_tool(**tool);
  return OpenedWindow{std::move(*scene), std::move(*tool), std::move(*view)};
}

Error explain_no_hub(const Address& hub, double seconds) {
  return {fmt::format("no hub at {} accepted it within {} s; start io_node there, give another address with --hub, or give the hub's --key",
                      to_string(hub), seconds)};
}

// Returns 0, or the exit code if options do not go together, or if something that they need is missing.
int check(VisionOptions& options) {
  if (const auto sound = check_annotator_options(options.annotations); !sound) return reject_options(sound.error());
  if (const auto writable = check_screenshot(options.screenshot); !writable) return give_up(writable.error());
  if (const auto screen = find_screen(options); !screen) return give_up(screen.error());
  if (const auto fits = check_headset(options); !fits) return reject_options(fits.error());
  if (const auto possible = check_head(options); !possible) return reject_options(possible.error());
  return 0;
}

int run(VisionOptions& options) {
  const StopSignal stop;  // first, so that a signal ends the program in order at any point
  const auto hub = parse_address(options.hub);
  if (!hub) return give_up(hub.error());
  if (const int code = check(options); code != 0) return code;
  const auto head = open_head_tracker(options);
  if (!head) return give_up(head.error());
  SteadyClock clock;
  if (!options.session.empty()) return show_recording(options, head->get(), clock, stop);
  const auto key = find_role_key(options.key_file, *hub, KeyRole::vision);
  if (!key) return give_up(key.error());
  auto headset = connect_headset(options);
  if (!headset) return give_up(headset.error());
  const auto scene_path = find_scene(options.scene);
  std::optional<SceneReload> reload;  // before the scene is read, so that no change of the file is missed
  if (options.watch_scene) reload.emplace(scene_path, options.loading);
  auto opened = open_window(scene_path, options);
  if (!opened) return give_up(opened.error());
  StereoView& view = *opened->view;
  if (options.bench_frames > 0) {
    print_text("{}\n", run_bench(view, clock, options.bench_frames, options.plots));
    return 0;
  }
  auto endpoint = open_udp_endpoint(options.bind.empty() ? any_address_like(*hub) : options.bind);
  if (!endpoint) return give_up(endpoint.error());
  SealedClient sealed(**endpoint, clock, *key, *hub);
  HubClient client(sealed, clock, NodeRole::vision, *hub);
  const auto other = open_other_link(options, clock);
  if (!other) return give_up(other.error());
  VisionSession session(view, client, clock, options);
  LiveScene live(view, options, std::move(opened->scene));
  if (reload) live.watch(&*reload);
  session.set_live_scene(&live);
  if (opened->tool) session.set_tool(opened->tool->given_hash);
  auto annotator = Annotator::open(view, live.scene(), options.scene_radius_m, options.annotations, !opened->tool);
  if (!annotator) return give_up(annotator.error());
  session.set_annotator(annotator->get());
  (*annotator)->set_carved_objects(&live.carved());
  (*annotator)->set_moved_objects(&live.moved());
  if (*other) session.set_other_hand(&(*other)->hand);
  std::optional<SpaceHead> space_head;
  if (options.has_space_head) session.set_space_head(&space_head.emplace(make_hid_opener(HidKind::space_mouse, "")));
  std::optional<SpaceKnobs> knobs;
  session.set_head_tracker(head->get());
  const auto show = open_headset(std::move(*headset), view, options);
  if (!show) return give_up(show.error());
  session.set_headset(show->get());
  if (options.has_space_knobs) session.set_knobs(&knobs.emplace(make_hid_opener(HidKind::space_mouse, "")));
  if (reload) reload->start();
  const auto ended = session.run(stop);
  print_text("vision_node: {}; view transforms sent {}\n", session.step().frames().describe(), session.step().view_transform().sent());
  if (!ended) return give_up(ended.error());
  // If only a picture was requested, it has been written: then it does not matter that there was no hub.
  if (options.seconds > 0.0 && client.counts().joins == 0 && options.screenshot.empty() && !stop.stop_requested()) {
    return give_up(explain_no_hub(*hub, options.seconds));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  outlive_readers();
  check_cpu("vision_node");
  check_descriptors("vision_node");
  start_log("vision_node");
  auto parsed = parse_vision_options(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  return run(std::get<VisionOptions>(parsed));
}
