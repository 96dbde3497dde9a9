#include "devices/haply_messages.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace hapton::haply {
namespace {

using Json = nlohmann::json;

// The home position of the cursor, which is the origin of W, in the service's axes.
const Vec3& home_m() {
  static const Vec3 kHome(0.0, -0.12, 0.15);
  return kHome;
}

const Json* find(const Json& in, const char* key) {
  if (!in.is_object()) return nullptr;
  const auto found = in.find(key);
  return found != in.end() ? &*found : nullptr;
}

std::optional<double> number(const Json* in, const char* key) {
  const Json* value = in != nullptr ? find(*in, key) : nullptr;
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double is = value->get<double>();
  return std::isfinite(is) ? std::optional(is) : std::nullopt;
}

std::string text(const Json* in, const char* key) {
  const Json* value = in != nullptr ? find(*in, key) : nullptr;
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<Vec3> vector(const Json* in) {
  const auto x = number(in, "x"), y = number(in, "y"), z = number(in, "z");
  return x && y && z ? std::optional(Vec3(*x, *y, *z)) : std::nullopt;
}

std::optional<Quat> quaternion(const Json& in) {
  const auto v = vector(&in);
  const auto w = number(&in, "w");
  if (!v || !w) return std::nullopt;
  const Quat q(*w, v->x(), v->y(), v->z());
  // Tolerance of the length: a quaternion rounded to two digits passes; anything else is not a rotation.
  constexpr double kTolerance = 0.1;
  return std::abs(q.norm() - 1.0) < kTolerance ? std::optional(q.normalized()) : std::nullopt;
}

Placement read_placement(const Json* in) {
  Placement placement;
  if (in == nullptr) return placement;
  if (const Json* position = find(*in, "position")) placement.position_m = vector(position);
  if (const Json* rotation = find(*in, "rotation")) placement.rotation = quaternion(*rotation);
  if (const Json* scale = find(*in, "scale")) placement.scale = vector(scale);
  return placement;
}

std::optional<Arm> read_arm(const Json& json) {
  const Json* state = find(json, "state");
  const auto position = state != nullptr ? vector(find(*state, "cursor_position")) : std::nullopt;
  Arm arm;
  arm.id = text(&json, "device_id");
  if (!position || arm.id.empty()) return std::nullopt;
  arm.position_m = *position;
  arm.transform = read_placement(find(*state, "transform"));
  const Json* config = find(json, "config");
  if (config != nullptr) arm.mount = read_placement(find(*config, "mount"));
  arm.model = text(config, "type");
  arm.firmware = text(config, "extended_firmware_version");
  const Json* status = find(json, "status");
  const Json* calibrated = status != nullptr ? find(*status, "calibrated") : nullptr;
  arm.is_calibrated = calibrated == nullptr || !calibrated->is_boolean() || calibrated->get<bool>();
  return arm;
}

std::optional<Grip> read_grip(const Json& json) {
  const Json* state = find(json, "state");
  if (state == nullptr) return std::nullopt;
  Grip grip;
  const Json* orientation = find(*state, "orientation");
  if (const auto q = orientation != nullptr ? quaternion(*orientation) : std::nullopt) grip.q_WT = to_w(*q);
  const Json* buttons = find(*state, "buttons");
  unsigned bit = 1;
  for (const char* name : {"a", "b", "c"}) {
    const Json* button = buttons != nullptr ? find(*buttons, name) : nullptr;
    if (button != nullptr && button->is_boolean() && button->get<bool>()) grip.buttons |= bit;
    bit <<= 1;
  }
  return grip;
}

std::string quoted(std::string_view id) { return Json(std::string(id)).dump(-1, ' ', true, Json::error_handler_t::replace); }

std::string command(std::string_view arm_id, const Vec3& f) {
  return fmt::format(R"("inverse3":[{{"device_id":{},"commands":{{"set_cursor_force":{{"vector":{{"x":{},"y":{},"z":{}}}}}}}}}])",
                     quoted(arm_id), f.x(), f.y(), f.z());
}

}  // namespace

Vec3 to_w(const Vec3& p_m) {
  const Vec3 p = p_m - home_m();
  return {p.x(), p.z(), -p.y()};
}
Vec3 force_from_w(const Vec3& force_n) { return {force_n.x(), -force_n.z(), force_n.y()}; }
Quat to_w(const Quat& q) { return {q.w(), q.x(), q.z(), -q.y()}; }

Result<State> read_state(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return fail("the Haply Inverse Service sent something that is not a JSON object");
  State state;
  if (const Json* arms = find(json, "inverse3"); arms != nullptr && arms->is_array()) {
    for (const Json& each : *arms) {
      if (auto arm = read_arm(each)) state.arms.push_back(std::move(*arm));
    }
  }
  for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
    const Json* grips = find(json, kind);
    if (state.grip || grips == nullptr || !grips->is_array() || grips->empty()) continue;
    state.grip = read_grip(grips->front());
  }
  return state;
}

Result<Version> read_version(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  const Json* data = find(json, "data");
  const std::string version_text = hapton::haply::text(data != nullptr ? data : &json, "project_version");
  Version version;
  if (std::sscanf(version_text.c_str(), "%d.%d", &version.major, &version.minor) != 2) return fail("no project_version in its reply");
  return version;
}

std::string describe_version_problem(const Version& version) {
  const bool is_old = version.major < 3 || (version.major == 3 && version.minor < 5);
  if (is_old) return "this io_node needs 3.5 or later, which has another message format: update the service with the Haply Hub";
  return version.major > 3 ? "this io_node knows 3.5 and later versions of 3 only: install one of them, or a newer Hapton" : "";
}

void Placement::update(const Placement& newer) {
  if (newer.position_m) position_m = newer.position_m;
  if (newer.rotation) rotation = newer.rotation;
  if (newer.scale) scale = newer.scale;
}

bool Placement::is_scaled() const {
  // Tolerance of a scale factor: single precision has seven digits.
  constexpr double kTolerance = 1e-6;
  return scale && (scale->array() - 1.0).abs().maxCoeff() > kTolerance;
}

Vec3 Placement::inverse(const Vec3& p_m) const {
  return rotation.value_or(Quat::Identity()).conjugate() * (p_m - position_m.value_or(Vec3::Zero()));
}

Vec3 Placement::turn(const Vec3& vector) const { return rotation.value_or(Quat::Identity()) * vector; }

void Session::update(const Arm& arm) {
  mount.update(arm.mount);
  transform.update(arm.transform);
}

Vec3 Session::to_w(const Vec3& position_m) const { return haply::to_w(mount.inverse(transform.inverse(position_m))); }
Vec3 Session::force_from_w(const Vec3& force_n) const { return transform.turn(mount.turn(haply::force_from_w(force_n))); }

std::string first_message(std::string_view arm_id) {
  constexpr std::string_view kSession =
      R"("session":{"configure":{"profile":{"name":"org.hapton:io_node"},"basis":{"permutation":"XYZ"}}})";
  return fmt::format("{{{},{}}}", kSession, command(arm_id, Vec3::Zero()));
}

std::string force_message(std::string_view arm_id, const Vec3& force_n) { return fmt::format("{{{}}}", command(arm_id, force_n)); }

}  // namespace hapton::haply
