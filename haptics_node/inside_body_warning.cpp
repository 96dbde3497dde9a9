#include "haptics_node/inside_body_warning.h"

#include <chrono>
#include <utility>

#include "core/collision/box.h"
#include "core/geometry/winding_number.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// The smallest winding number that counts as inside a body. It is whole for a closed body; small holes reduce it slightly.
constexpr double kMinWinding = 0.9;
constexpr auto kInsideCheckPeriod = std::chrono::milliseconds(50);
constexpr int kPeriodsBetweenChecks = 6;  // periods between two checks while the hand is inside, since a check may take 0.1 s

}  // namespace

Enclosure find_enclosure(const TouchScene& scene, const Vec3& p_S) {
  Enclosure found;
  for (const TouchObject& object : scene.objects) {
    if (object.motion != nullptr || object.command_pivot || Box::of(object.mesh->vertices).distance_squared(p_S) > 0.0) continue;
    if (compute_winding_number(*object.mesh, p_S) > kMinWinding) found = {true, object.material.two_sided && !object.sculpt};
    if (found.is_inside && found.two_sided) break;
  }
  return found;
}

InsideBodyWarning::InsideBodyWarning(TouchScene scene) : scene_(std::move(scene)), thread_(start_thread([this] { run(); })) {}

InsideBodyWarning::~InsideBodyWarning() {
  stop_.store(true);
  thread_.join();
}

void InsideBodyWarning::set_scene(TouchScene scene) {
  const std::scoped_lock lock(mutex_);
  scene_ = std::move(scene);
}

// Polls, since to wake this thread would be a system call in the loop that replies to the hub.
void InsideBodyWarning::run() {
  for (int periods_left = 0; !stop_.load();) {
    std::this_thread::sleep_for(kInsideCheckPeriod);
    if (periods_left-- > 0 || !hands_.take()) continue;
    check(hands_.value());
    periods_left = is_inside() ? kPeriodsBetweenChecks : 0;
  }
}

void InsideBodyWarning::check(const Hand& hand) {
  const bool is_start = std::exchange(checked_start_, hand.start) != hand.start;
  const bool was_inside = is_inside();
  if (!is_start && !was_inside) return;  // after the start no hand gets inside without contact
  Enclosure enclosure;
  {
    const std::scoped_lock lock(mutex_);
    enclosure = find_enclosure(scene_, is_start ? hand.p_SStart : hand.p_S);
  }
  // A device point that is pressed out through a wall from within is still in contact with it.
  const bool is_inside_now = enclosure.is_inside || (was_inside && !is_start && hand.contact);
  is_inside_.store(is_inside_now, std::memory_order_release);
  is_watching_.store(is_inside_now, std::memory_order_release);
  if (is_inside_now && !was_inside && enclosure.two_sided) {
    log_warning(
        "the stylus, or the tool that it holds, is inside a body of the scene and feels its inner side: end haptics_node, lead the "
        "stylus out, and start it again");
  } else if (is_inside_now && !was_inside) {
    log_warning("the stylus is inside a body of the scene: that body gives no force until the stylus has left it");
  }
  if (was_inside && !is_inside_now) log_info("the stylus is outside now: the body gives a force like any other");
}

}  // namespace hapton
