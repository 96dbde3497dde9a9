#include "tools/demo/demo_step.h"

#include <fmt/core.h>

#include "tools/demo/demo_shapes.h"

namespace hapton {
namespace {

constexpr double kRoundS = 8.0;   // time on the surface in a motion that is repeated; a free choice
constexpr double kStayS = 60.0;   // so long that the hand does not come and go while the user looks at something else
constexpr double kDelayMs = 4.0;  // each way; with jitter the round trip is above the 8 ms at which io_node asks for patches

Result<DemoPath> rest_on_the_bonnet(const Scene& scene) { return make_rest_path(scene, 0.03, 0.03, kRoundS); }
Result<DemoPath> stay_on_the_bonnet(const Scene& scene) { return make_rest_path(scene, 0.03, 0.03, kStayS); }
Result<DemoPath> along_the_groove(const Scene&) { return make_groove_path(); }
Result<DemoPath> against_the_wall(const Scene&) { return make_tap_path(); }
Result<DemoPath> over_the_ball(const Scene&) { return make_arc_path(demo_heavy::kRadiusM); }

}  // namespace

std::span<const DemoStep> demo_steps() {
  static const std::vector<DemoStep> kSteps = {
      {.name = "rest on the car",
       .watch_for =
           "The hand presses into the sheet metal, and the tip stays on it: the red dot is the device. Each ring of the arrow is 1 N.\n"
           "Move the hand yourself with the left mouse button; the wheel presses, the right button rotates the view.",
       .scene = "scenes/car_front.toml",
       .make_path = rest_on_the_bonnet,
       .evaluate = evaluate_rest},
      {.name = "slide in a groove",
       .watch_for = "The hand moves back and forth on a straight line. The walls of the groove guide the probe along its bends.",
       .scene = "scenes/groove.toml",
       .picture_at = "3",
       .make_path = along_the_groove,
       .evaluate = evaluate_groove},
      {.name = "a wall thinner than a step",
       .watch_for = "The wall is 0.1 mm thick, and between two samples the hand moves several times that.\n"
                    "The device passes through it, but the probe does not: it stays on the side that it came from.",
       .scene = "scenes/thin_wall.toml",
       .vision = {"--view-yaw-deg", "-52"},
       .make_path = against_the_wall,
       .evaluate = evaluate_wall},
      {.name = "a heavy mesh",
       .watch_for = "1,310,720 triangles, touched with all of them and drawn at the level of detail that a frame has time for.\n"
                    "Turn it with x, y and z: the surface that you touch turns with the picture.",
       .scene = "",
       .picture_at = "5",
       .make_path = over_the_ball,
       .evaluate = evaluate_heavy},
      {.name = "a slow network",
       .watch_for =
           "The network between the device and the forces has 4 ms of delay each way, 2 ms of jitter and 2 % of loss.\n"
           "So io_node gets the parts of the scene around the hand and computes the force itself: the car is as hard as without it.",
       .scene = "scenes/car_front.toml",
       .relay = {"--delay-ms", fmt::format("{}", kDelayMs), "--jitter-ms", "2", "--loss", "0.02"},
       .make_path = rest_on_the_bonnet,
       .evaluate = [](const DemoEvidence& evidence) { return evaluate_network(evidence, 2.0 * kDelayMs); }},
      {.name = "a node dies",
       .watch_for = "The haptics node is killed while the hand presses, and started again.\n"
                    "The force is released within 20 ms, the picture says why there is no force, and the contact goes on where it was.",
       .scene = "scenes/car_front.toml",
       .event = DemoStep::Event::haptics_dies,
       .make_path = stay_on_the_bonnet,
       .evaluate = evaluate_death},
  };
  return kSteps;
}

std::string demo_file_name(std::size_t number) {
  std::string name = fmt::format("{}-{}", number, demo_steps()[number - 1].name);
  for (char& c : name) c = c == ' ' ? '-' : c;
  return name;
}

}  // namespace hapton
