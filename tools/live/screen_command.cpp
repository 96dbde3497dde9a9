#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "link/hub_connection.h"
#include "link/link_key.h"
#include "runtime/atomic_file.h"
#include "runtime/stop_signal.h"
#include "scene/screen_file.h"
#include "tools/commands.h"
#include "tools/live/corner_touch.h"
#include "tools/live/corners_text.h"

namespace hapton {
namespace {

struct ScreenOptions {
  HubConnection::Settings hub;
  std::string corners;
  std::filesystem::path out = "screen.toml";
};

constexpr double kScreenJoinTimeoutS = 2.0;  // how long to wait for the hub; this and the next two values are free choices
constexpr std::int64_t kScreenMaxWaitNs = 20 * kNanosecondsPerMillisecond;
constexpr std::int64_t kSampleTimeoutNs = 5 * kNanosecondsPerSecond;

void print_prompt(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

// Asks a person to touch the corners of the picture, one after the other.
class CornerSession {
 public:
  explicit CornerSession(HubConnection& connection) : client_(connection.client()), clock_(connection.clock()) {}

  Result<ScreenCorners> run() {
    const StopSignal stop;
    print_prompt(
        fmt::format("Touch the corners of the picture with the tip of the stylus. At each, press a button of the stylus, or hold the tip "
                    "still for {:g} s.",
                    CornerTouch::kHoldS));
    ask_for_corner();
    last_sample_ns_ = clock_.now_ns();
    Datagram datagram;
    while (next_corner_ < corners_.size()) {
      if (stop.stop_requested()) return fail("stopped before all corners were touched; nothing was written");
      const bool has_datagram = client_.receive(datagram, clock_.now_ns() + kScreenMaxWaitNs);
      const auto* probe = has_datagram ? std::get_if<ProbeState>(&datagram.message) : nullptr;
      if (probe != nullptr) accept(*probe);
      if (clock_.now_ns() - last_sample_ns_ > kSampleTimeoutNs) {
        return fail("no sample of the device has come for {} s; `hapton top` shows whether io_node runs and the device is connected",
                    kSampleTimeoutNs / kNanosecondsPerSecond);
      }
    }
    return corners_;
  }

 private:
  void ask_for_corner() const {
    print_prompt(fmt::format("{} of {}: the {} corner", next_corner_ + 1, corners_.size(), kCornerNames[next_corner_]));
  }

  void accept(const ProbeState& probe) {
    last_sample_ns_ = clock_.now_ns();
    client_.send(FrameAck{.echo_sample = probe.sample, .echo_sample_time_ns = probe.sample_time_ns, .every_sample = true});
    if (!is_measuring(probe.status)) return;
    switch (touch_.add(probe)) {
      case CornerTouch::Event::none:
        return;
      case CornerTouch::Event::moved:
        fmt::print(stderr, "hapton screen: the tip moved by {:.1f} mm after the press; hold it still for {:g} s and press again\n",
                   1e3 * touch_.moved_m(), CornerTouch::kPressS);
        return;
      case CornerTouch::Event::touched:
        const Vec3 mm = 1e3 * touch_.p_W();
        print_prompt(fmt::format("  at {:.1f},{:.1f},{:.1f} mm", mm.x(), mm.y(), mm.z()));
        corners_[next_corner_++] = touch_.p_W();
        if (next_corner_ < corners_.size()) ask_for_corner();
    }
  }

  bool is_measuring(ProbeStatus status) {
    const bool is_away = status == ProbeStatus::device_away || status == ProbeStatus::calibrating;
    if (is_away && !was_device_away_) {
      print_prompt(status == ProbeStatus::device_away ? "the device does not respond; waiting for it"
                                                      : "the device is being calibrated; waiting for it");
    }
    was_device_away_ = is_away;
    return !is_away;
  }

  HubClient& client_;
  const Clock& clock_;
  CornerTouch touch_;
  ScreenCorners corners_ = {};
  std::size_t next_corner_ = 0;
  std::int64_t last_sample_ns_ = 0;
  bool was_device_away_ = false;
};

Result<ScreenCorners> find_corners(const ScreenOptions& options) {
  if (!options.corners.empty()) return parse_corners(options.corners);
  const auto connection = HubConnection::open(NodeRole::vision, options.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kScreenJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  return CornerSession(**connection).run();
}

Result<void> measure_screen(const ScreenOptions& options) {
  const auto corners = find_corners(options);
  if (!corners) return tl::unexpected(corners.error());
  const auto fit = fit_screen(*corners);
  if (!fit) return tl::unexpected(fit.error());
  if (auto usable = check_screen(fit->screen); !usable) return usable;
  print_prompt(describe_fit(*fit));
  if (auto written = write_file_atomically(options.out, write_screen(fit->screen)); !written) return written;
  print_prompt(fmt::format("vision_node --screen {}", options.out.string()));
  return {};
}

int run(const ScreenOptions& options) {
  const auto done = measure_screen(options);
  if (!done) fmt::print(stderr, "hapton screen: {}\n", done.error().what);
  return done ? 0 : 1;
}

}  // namespace

void add_screen_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<ScreenOptions>();
  const CommandLine command = app.add_subcommand("screen", "Measure where the screen stands, by its corners, for vision_node --screen");
  command.add_option("--hub", options->hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->hub.key_file, kKeyHelp);
  command.add_option("--corners", options->corners,
                     "Corners that were measured without the device: \"X,Y,Z;X,Y,Z;X,Y,Z;X,Y,Z\" in m, frame W: lower left, lower right, "
                     "upper right, upper left");
  command.add_option("--out", options->out, "File (TOML) to write").file_to_write().shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
