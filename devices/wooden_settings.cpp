#include "devices/wooden_settings.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "runtime/toml_reader.h"

namespace hapton {
namespace {

constexpr double kReachM = 0.1;  // of the 2016 edition
// Limits of the values in a file, beyond any arm on a desk: a value outside is in a wrong unit.
constexpr double kMaxLengthM = 2.0;
constexpr double kMinDiameterM = 1e-3;
constexpr double kMaxForceN = 100.0;

void read_direction(TomlReader& reader, double& direction) {
  reader.read("direction", direction, -1.0, 1.0);
  if (std::abs(direction) != 1.0) reader.reject("direction", "'direction' is 1, or -1 where the encoder counts down as the angle grows");
}

double read_degrees(TomlReader& reader, std::string_view key) {
  double degrees = 0.0;
  reader.read(key, degrees, -360.0, 360.0);
  return degrees * std::numbers::pi / 180.0;
}

void read_body(TomlReader reader, WoodenArm::Body& body) {
  reader.allow({"capstan_diameter_m", "body_diameter_m", "length_m", "counts_per_turn", "torque_constant_nm_per_a", "direction", "rest_deg",
                "mass_kg", "mass_centre_m"});
  reader.read("capstan_diameter_m", body.capstan_diameter_m, kMinDiameterM, kMaxLengthM);
  reader.read("body_diameter_m", body.body_diameter_m, kMinDiameterM, kMaxLengthM);
  reader.read("length_m", body.length_m, 0.0, kMaxLengthM);
  reader.read("counts_per_turn", body.counts_per_turn, 1.0, 1e6);
  const double half_turn = 0.5 * body.counts_per_turn * body.body_diameter_m / body.capstan_diameter_m;
  if (half_turn > std::numeric_limits<std::int16_t>::max()) {
    reader.reject(
        "counts_per_turn",
        "the encoder's 16 bits must hold half a turn of the body: counts_per_turn * body_diameter_m / capstan_diameter_m at most 65534");
  }
  reader.read("torque_constant_nm_per_a", body.torque_constant_nm_per_a, 1e-4, 10.0);
  read_direction(reader, body.direction);
  body.rest_rad = read_degrees(reader, "rest_deg");
  reader.read("mass_kg", body.mass_kg, 0.0, 10.0);
  reader.read("mass_centre_m", body.mass_centre_m, -kMaxLengthM, kMaxLengthM);
}

void read_joint(TomlReader reader, WoodenWrist::Joint& joint) {
  reader.allow({"axis", "counts_per_turn", "direction", "offset_deg"});
  reader.require("axis");
  reader.read("axis", joint.axis, -1.0, 1.0);
  if (joint.axis.norm() < 1e-3) reader.reject("axis", "'axis' has zero length: one of its three numbers must not be zero");
  joint.axis.normalize();
  reader.read("counts_per_turn", joint.counts_per_turn, 1.0, 65534.0);  // half a turn fits into the encoder's 16 bits
  read_direction(reader, joint.direction);
  joint.offset_rad = read_degrees(reader, "offset_deg");
}

void read_limits(TomlReader& reader, WoodenSettings& settings) {
  DeviceLimits& limits = settings.limits;
  reader.read("max_force_n", limits.max_force_n, 0.1, kMaxForceN);
  reader.read("max_slew_n_per_s", limits.max_slew_n_per_s, 1.0, 1e6);
  reader.read("max_stiffness_n_per_m", limits.max_stiffness_n_per_m, 1.0, 1e5);
  reader.read("continuous_force_n", limits.continuous_force_n, 0.0, kMaxForceN);
  reader.read("peak_s", limits.peak_s, 0.0, 1e4);
  reader.read("max_speed_m_per_s", limits.max_speed_m_per_s, 0.0, 100.0);
  reader.read("max_current_a", settings.max_current_a, 0.01, 30.0);
  double radius_m = kReachM;
  reader.read("workspace_radius_m", radius_m, 1e-3, kMaxLengthM);
  limits.workspace_min_m = Vec3::Constant(-radius_m);
  limits.workspace_max_m = Vec3::Constant(radius_m);
}

}  // namespace

// 5 N, 1000 N/m and 0.1 m are those of the 2016 edition. Slew: the full force in 4 ms, faster than a wooden arm transmits it. Speed: twice
// that of a fast hand.
WoodenSettings WoodenSettings::make_default() {
  WoodenSettings settings;
  settings.limits = {.max_force_n = 5.0,
                     .max_slew_n_per_s = 1250.0,
                     .max_stiffness_n_per_m = 1000.0,
                     .workspace_min_m = Vec3::Constant(-kReachM),
                     .workspace_max_m = Vec3::Constant(kReachM),
                     .max_speed_m_per_s = 5.0};
  return settings;
}

Result<WoodenSettings> read_wooden_settings(const std::filesystem::path& path) {
  auto reader = TomlReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  WoodenSettings settings = WoodenSettings::make_default();
  reader->allow({"max_force_n", "max_slew_n_per_s", "max_stiffness_n_per_m", "continuous_force_n", "peak_s", "max_speed_m_per_s",
                 "max_current_a", "workspace_radius_m", "origin_m", "gravity_compensation", "report_bytes", "body_a", "body_b", "body_c",
                 "wrist"});
  read_limits(*reader, settings);
  reader->read("origin_m", settings.arm.origin_m, -kMaxLengthM, kMaxLengthM);
  reader->read("gravity_compensation", settings.has_gravity_compensation);
  reader->read("report_bytes", settings.report_bytes, 8, 14);
  if (reader->has("report_bytes") && settings.report_bytes != 8 && settings.report_bytes != 14) {
    reader->reject("report_bytes", "'report_bytes' is 8 or 14");
  }
  constexpr std::array kBodies = {"body_a", "body_b", "body_c"};
  for (std::size_t n = 0; n < 3; ++n) read_body(reader->table(kBodies[n]), settings.arm.bodies[n]);
  if (const auto joints = reader->tables("wrist"); !joints.empty()) {
    if (joints.size() != 3) reader->reject("wrist", "[[wrist]] must appear three times, for the encoders from the lower arm to the stylus");
    WoodenWrist wrist;
    for (std::size_t n = 0; n < std::min<std::size_t>(3, joints.size()); ++n) read_joint(joints[n], wrist.joints[n]);
    settings.wrist = wrist;
  }
  if (const auto read = reader->result(); !read) return tl::unexpected(read.error());
  return settings;
}

}  // namespace hapton
