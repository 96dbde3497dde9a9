#include "tools/doctor/display_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tools/doctor/display_probe.h"
#include "tools/doctor/run_in_child.h"

namespace hapton::doctor {
namespace {

constexpr double kProbeTimeoutS = 10.0;  // for the process that opens the display; a free choice
constexpr const char* kVirtualDisplayCommand = "xvfb-run -a -s '-screen 0 1280x1024x24' vision_node   # draws where nobody sees it";

bool is_drawn_by_cpu(const std::string& renderer) {
  constexpr std::array<std::string_view, 3> kSoftware = {"llvmpipe", "softpipe", "SWR"};
  return std::any_of(kSoftware.begin(), kSoftware.end(), [&](std::string_view name) { return renderer.find(name) != renderer.npos; });
}

Finding check_renderer(const std::string& display, const DisplayReply& reply) {
  const std::string observation = fmt::format("{}, OpenGL {} at {}", reply.renderer, reply.version, display);
  if (is_drawn_by_cpu(reply.renderer)) {
    return warning(
        "renderer", observation + ": the CPU draws, and takes time from the loops",
        "install the driver of the graphics card (sudo apt-get install firmware-misc-nonfree libgl1-mesa-dri, or nvidia-driver), or run "
        "vision_node on another host");
  }
  if (!reply.is_direct)
    return warning("renderer", observation + ": drawn through the X protocol, slowly",
                   "run vision_node on the host that the display is plugged into");
  return good("renderer", observation);
}

Finding check_stereo(const Machine& machine, const DisplayReply& reply) {
  if (reply.has_stereo) return good("quad-buffer stereo", "there: vision_node --stereo crystal_eyes");
  const bool is_wayland = !machine.environment("WAYLAND_DISPLAY").empty();
  return note(
      "quad-buffer stereo",
      fmt::format("none{}; the other modes of vision_node --stereo need none", is_wayland ? " (Wayland has none: log in with Xorg)" : ""),
      "it takes a professional card and, with NVIDIA's driver: sudo nvidia-xconfig --stereo=11");
}

}  // namespace

Findings check_display(const Machine& machine) {
  const std::string display = machine.environment("DISPLAY");
  if (display.empty())
    return {warning("display", "DISPLAY is not set, so vision_node cannot show anything here",
                    fmt::format("start it from a desktop, or: {}", kVirtualDisplayCommand))};
  if (!machine.queries().display) return {note("display", display + ", not checked")};
  const DisplayReply reply = machine.queries().display();
  if (!reply.error.empty())
    return {problem("display", fmt::format("{}: {}", display, reply.error),
                    fmt::format("start it from a desktop's own terminal (echo $DISPLAY there), or: {}", kVirtualDisplayCommand))};
  return {check_renderer(display, reply), check_stereo(machine, reply)};
}

DisplayReply try_display() {
  const ChildReply child_reply = run_in_child(
      [] {
        const DisplayReply reply = probe_display();
        return nlohmann::json({{"error", reply.error},
                               {"renderer", reply.renderer},
                               {"version", reply.version},
                               {"is_direct", reply.is_direct},
                               {"has_stereo", reply.has_stereo}})
            .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      },
      kProbeTimeoutS);
  DisplayReply reply;
  reply.error = child_reply.failure;
  const auto json = nlohmann::json::parse(child_reply.text, nullptr, false);
  if (!json.is_object()) return reply;
  reply.error = json.at("error");
  reply.renderer = json.at("renderer");
  reply.version = json.at("version");
  reply.is_direct = json.at("is_direct");
  reply.has_stereo = json.at("has_stereo");
  return reply;
}

}  // namespace hapton::doctor
