#include "link/protobuf_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "core/math/rigid_pose.h"
#include "hapton.pb.h"
#include "link/codec.h"
#include "link/wire_fields.h"

namespace hapton {
namespace {

template <class Field>
bool read_pose(const Field& field, std::array<float, 12>& X) {
  if (field.size() != static_cast<int>(X.size())) {
    return false;
  }
  std::copy(field.begin(), field.end(), X.begin());
  return is_rigid(X);
}

bool read_document(std::uint32_t from, ReportDocument& to) {
  to = static_cast<ReportDocument>(from);
  return from <= static_cast<std::uint32_t>(ReportDocument::csv);
}

template <class Field>
bool read_point(const Field& field, int first, SceneFacts::Point& point) {
  for (std::size_t axis = 0; axis < point.size(); ++axis) {
    point[axis] = field.Get(first + static_cast<int>(axis));
    if (!(std::abs(point[axis]) <= static_cast<float>(kMaxWireMagnitude))) return false;
  }
  return true;
}

}  // namespace

// --- writing ---

void write(const Hello& from, wire::Hello& to) { to.set_role(static_cast<wire::Role>(from.role)); }

void write(const Welcome& from, wire::Welcome& to) {
  to.set_accepted(from.accepted);
  to.set_servo_rate_hz(from.servo_rate_hz);
}

void write(const Bye&, wire::Bye&) {}

void write(const DeviceState& from, wire::DeviceState& to) {
  to.set_sample(from.sample);
  to.set_sample_time_ns(from.sample_time_ns);
  write_vector(*to.mutable_p_wd_m(), from.p_WD);
  write_rotation(*to.mutable_q_wt(), from.q_WT);
  to.set_buttons(from.buttons);
  to.set_is_resumed(from.is_resumed);
  write_vector(*to.mutable_p_wp_m(), from.p_WP);
  to.clear_scene_time_ns();
  if (from.scene_time_ns >= 0) to.set_scene_time_ns(from.scene_time_ns);
}

// Cleared fields keep their memory for the next message.
template <class Wire>
void write_push(const std::optional<ObjectPush>& push, Wire& to) {
  to.clear_push_force_n();
  to.clear_push_torque_nm();
  if (!push) return;
  write_vector(*to.mutable_push_force_n(), push->force_n);
  write_vector(*to.mutable_push_torque_nm(), push->torque_nm);
}

template <class Wire>
bool read_push(const Wire& from, std::optional<ObjectPush>& push) {
  push.reset();
  if (from.push_force_n_size() == 0 && from.push_torque_nm_size() == 0) return true;
  push.emplace();
  return read_vector(from.push_force_n(), push->force_n) && read_vector(from.push_torque_nm(), push->torque_nm);
}

template <class Wire>
void write_haptons(const std::optional<std::uint32_t>& haptons, Wire& to) {
  to.clear_haptons();
  if (haptons) to.set_haptons(*haptons);
}

template <class Wire>
std::optional<std::uint32_t> read_haptons(const Wire& from) {
  return from.has_haptons() ? std::optional<std::uint32_t>(from.haptons()) : std::nullopt;
}

void write(const ForceCommand& from, wire::ForceCommand& to) {
  to.set_echo_sample(from.echo_sample);
  to.set_echo_sample_time_ns(from.echo_sample_time_ns);
  write_vector(*to.mutable_force_n(), from.force_n);
  write_vector(*to.mutable_visual_offset_m(), from.visual_offset_m);
  to.set_contact(from.contact);
  to.set_compute_ns(from.compute_ns);
  to.set_skipped_samples(from.skipped_samples);
  to.set_view_revision(from.view_revision);
  to.set_method_serial(from.method_serial);
  to.set_replied_before(from.replied_before);
  to.set_material_serial(from.material_serial);
  to.set_touched(write_object(from.object));
  write_vector(*to.mutable_torque_nm(), from.torque_nm);
  write_vector(*to.mutable_visual_turn(), from.visual_turn);
  to.set_scene_time_ns(from.scene_time_ns);
  to.set_move_serial(from.move_serial);
  to.set_carve_serial(from.carve_serial);
  to.set_shape_serial(from.shape_serial);
  write_push(from.push, to);
  write_haptons(from.haptons, to);
  to.clear_held_offset_m();
  if (from.held_offset_m) write_vector(*to.mutable_held_offset_m(), *from.held_offset_m);
}

void write(const ViewTransform& from, wire::ViewTransform& to) {
  to.set_revision(from.revision);
  write_numbers(from.X_WS, *to.mutable_x_ws());
}

void write(const ProbeState& from, wire::ProbeState& to) {
  to.set_sample(from.sample);
  to.set_sample_time_ns(from.sample_time_ns);
  write_vector(*to.mutable_p_wd_m(), from.p_WD);
  write_rotation(*to.mutable_q_wt(), from.q_WT);
  write_vector(*to.mutable_visual_offset_m(), from.visual_offset_m);
  write_vector(*to.mutable_force_n(), from.force_n);
  to.set_contact(from.contact);
  to.set_buttons(from.buttons);
  to.set_servo_rate_hz(from.servo_rate_hz);
  to.set_round_trip_p50_us(from.round_trip_p50_us);
  to.set_round_trip_p99_us(from.round_trip_p99_us);
  to.set_view_revision(from.view_revision);
  to.set_status(static_cast<std::uint32_t>(from.status));
  to.set_energy_percent(from.energy_percent);
  to.set_touched(write_object(from.object));
  write_vector(*to.mutable_torque_nm(), from.torque_nm);
  to.set_force_limit_n(from.force_limit_n);
  write_vector(*to.mutable_visual_turn(), from.visual_turn);
  to.set_scene_time_ns(from.scene_time_ns);
  write_push(from.push, to);
  write_haptons(from.haptons, to);
}

void write(const FrameAck& from, wire::FrameAck& to) {
  to.set_echo_sample(from.echo_sample);
  to.set_echo_sample_time_ns(from.echo_sample_time_ns);
  to.set_frame_rate_hz(from.frame_rate_hz);
  to.set_held_ns(from.held_ns);
  to.set_rest_ns(from.rest_ns);
  to.set_unchanged(from.unchanged);
  to.set_every_sample(from.every_sample);
}

void write(const HandTarget& from, wire::HandTarget& to) {
  to.set_active(from.active);
  write_vector(*to.mutable_p_wh_m(), from.p_WH);
  to.set_buttons(from.buttons);
  write_vector(*to.mutable_turn_rad(), from.turn_rad);
}

void write(const ObjectPose& from, wire::ObjectPose& to) {
  to.set_serial(from.serial);
  to.set_object(static_cast<std::uint32_t>(from.object));
  to.set_is_held(from.is_held);
  write_vector(*to.mutable_p_m(), from.p_m);
  write_rotation(*to.mutable_q(), from.q);
}

void write(const Settings& from, wire::Settings& to) {
  to.set_servo_rate_hz(from.servo_rate_hz);
  write_text(from.method, *to.mutable_method());
  to.set_report_now(from.report_now);
  to.set_reset_faults(from.reset_faults);
  to.set_method_request(from.method_request);
}

void write(const HapticsSetup& from, wire::HapticsSetup& to) {
  to.set_method_serial(from.method_serial);
  to.set_view_revision(from.view_revision);
  write_numbers(from.X_WS, *to.mutable_x_ws());
  to.set_scene_hash(from.scene_hash);
  write_text(from.scene, *to.mutable_scene());
  write_text(from.build, *to.mutable_build());
  write_text(from.method, *to.mutable_method());
  to.set_scene_loading(from.scene_loading);
  to.set_material_serial(from.material_serial);
  to.set_method_request(from.method_request);
  write_text(from.rejection, *to.mutable_rejection());
}

void write(const SceneFacts& from, wire::SceneFacts& to) {
  to.set_given_hash(from.given_hash);
  write_numbers(from.lowest_m, *to.mutable_lowest_m());
  write_numbers(from.highest_m, *to.mutable_highest_m());
  to.mutable_points_m()->Clear();
  for (std::size_t i = 0; i < std::min<std::size_t>(from.point_count, from.points_m.size()); ++i) {
    add_numbers(from.points_m[i], *to.mutable_points_m());
  }
  to.set_preparing_s(from.preparing_s);
  to.set_is_hand_inside(from.is_hand_inside);
  to.set_tool_hash(from.tool_hash);
}

void write(const ReportRequest& from, wire::ReportRequest& to) {
  to.set_document(static_cast<std::uint32_t>(from.document));
  to.set_revision(from.revision);
  to.set_part(from.part);
}

void write(const ReportPart& from, wire::ReportPart& to) {
  to.set_document(static_cast<std::uint32_t>(from.document));
  to.set_revision(from.revision);
  to.set_part(from.part);
  to.set_parts(from.parts);
  to.mutable_text()->assign(from.text.data(), std::min<std::size_t>(from.size, from.text.size()));
}

void write(const ViewRejected& from, wire::ViewRejected& to) { to.set_revision(from.revision); }

void write(const LoopFacts& from, wire::LoopFacts& to) {
  write_text(from.device, *to.mutable_device());
  to.set_servo_rate_hz(from.servo_rate_hz);
  to.set_round_trip_s(from.round_trip_s);
  if (from.max_torque_nm > 0.0F) to.set_max_torque_nm(from.max_torque_nm);
}

void write(const Marker& from, wire::Marker& to) {
  to.set_request(from.request);
  write_text(from.text, *to.mutable_text());
}

void write(const MarkerReply& from, wire::MarkerReply& to) {
  to.set_request(from.request);
  to.set_sample(from.sample);
  to.set_status(static_cast<std::uint32_t>(from.status));
}

// --- reading: false for a value that the contract rules out ---

bool read(const wire::Hello& from, Hello& to) {
  to.role = static_cast<NodeRole>(from.role());
  return from.role() >= wire::ROLE_IO && from.role() <= wire::ROLE_TOOL;
}

bool read(const wire::Welcome& from, Welcome& to) {
  to.accepted = from.accepted();
  to.servo_rate_hz = from.servo_rate_hz();
  return is_servo_rate(to.servo_rate_hz);
}

bool read(const wire::Bye&, Bye&) { return true; }

bool read(const wire::DeviceState& from, DeviceState& to) {
  to.sample = from.sample();
  to.sample_time_ns = from.sample_time_ns();
  to.buttons = from.buttons();
  to.is_resumed = from.is_resumed();
  to.scene_time_ns = from.has_scene_time_ns() ? from.scene_time_ns() : -1;
  if (to.scene_time_ns < -1 || !is_wire_time(to.scene_time_ns) || !is_wire_time(to.sample_time_ns)) return false;
  return read_vector(from.p_wd_m(), to.p_WD) && read_rotation(from.q_wt(), to.q_WT) && read_vector(from.p_wp_m(), to.p_WP);
}

bool read(const wire::ForceCommand& from, ForceCommand& to) {
  to.echo_sample = from.echo_sample();
  to.echo_sample_time_ns = from.echo_sample_time_ns();
  to.contact = from.contact();
  to.compute_ns = from.compute_ns();
  to.skipped_samples = from.skipped_samples();
  to.view_revision = from.view_revision();
  to.method_serial = from.method_serial();
  to.replied_before = from.replied_before();
  to.material_serial = from.material_serial();
  to.object = read_object(from.touched());
  to.scene_time_ns = from.scene_time_ns();
  to.move_serial = from.move_serial();
  to.carve_serial = from.carve_serial();
  to.shape_serial = from.shape_serial();
  to.haptons = read_haptons(from);
  to.held_offset_m.reset();
  return is_wire_time(to.echo_sample_time_ns) && is_wire_time(to.scene_time_ns) && read_vector(from.force_n(), to.force_n) &&
         read_vector(from.visual_offset_m(), to.visual_offset_m) && read_optional_vector(from.torque_nm(), to.torque_nm) &&
         read_optional_vector(from.visual_turn(), to.visual_turn) && read_push(from, to.push) &&
         (from.held_offset_m().empty() || read_vector(from.held_offset_m(), to.held_offset_m.emplace()));
}

bool read(const wire::ProbeState& from, ProbeState& to) {
  to.sample = from.sample();
  to.sample_time_ns = from.sample_time_ns();
  to.contact = from.contact();
  to.buttons = from.buttons();
  to.servo_rate_hz = from.servo_rate_hz();
  to.round_trip_p50_us = from.round_trip_p50_us();
  to.round_trip_p99_us = from.round_trip_p99_us();
  to.view_revision = from.view_revision();
  to.energy_percent = from.energy_percent();
  to.force_limit_n = from.force_limit_n();
  to.object = read_object(from.touched());
  to.haptons = read_haptons(from);
  to.scene_time_ns = from.scene_time_ns();
  // An unknown status of a newer hub is no reason to reject the state.
  to.status =
      from.status() <= static_cast<std::uint32_t>(ProbeStatus::hand_inside) ? static_cast<ProbeStatus>(from.status()) : ProbeStatus::ok;
  if (!is_wire_time(to.sample_time_ns) || !is_wire_time(to.scene_time_ns)) return false;
  return read_vector(from.p_wd_m(), to.p_WD) && read_rotation(from.q_wt(), to.q_WT) &&
         read_vector(from.visual_offset_m(), to.visual_offset_m) && read_vector(from.force_n(), to.force_n) &&
         read_optional_vector(from.torque_nm(), to.torque_nm) && read_optional_vector(from.visual_turn(), to.visual_turn) &&
         read_push(from, to.push) && is_amount(to.servo_rate_hz) && is_amount(to.round_trip_p50_us) && is_amount(to.round_trip_p99_us) &&
         is_amount(to.force_limit_n);
}

bool read(const wire::FrameAck& from, FrameAck& to) {
  to.echo_sample = from.echo_sample();
  to.echo_sample_time_ns = from.echo_sample_time_ns();
  to.frame_rate_hz = from.frame_rate_hz();
  to.held_ns = from.held_ns();
  to.rest_ns = from.rest_ns();
  to.unchanged = from.unchanged();
  to.every_sample = from.every_sample();
  return is_wire_time(to.echo_sample_time_ns) && is_amount(to.frame_rate_hz);
}

bool read(const wire::HandTarget& from, HandTarget& to) {
  to.active = from.active();
  to.buttons = from.buttons();
  to.turn_rad.setZero();
  if (!from.turn_rad().empty() && !read_vector(from.turn_rad(), to.turn_rad)) return false;
  return read_vector(from.p_wh_m(), to.p_WH);
}

bool read(const wire::ObjectPose& from, ObjectPose& to) {
  to.serial = from.serial();
  to.is_held = from.is_held();
  if (to.serial == 0 || from.object() > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max())) return false;
  to.object = static_cast<std::int32_t>(from.object());
  return read_vector(from.p_m(), to.p_m) && read_rotation(from.q(), to.q);
}

bool read(const wire::Settings& from, Settings& to) {
  to.servo_rate_hz = from.servo_rate_hz();
  to.report_now = from.report_now();
  to.reset_faults = from.reset_faults();
  to.method_request = from.method_request();
  const std::string& method = from.method();
  if (method.size() > to.method.size() || !std::all_of(method.begin(), method.end(), [](char c) { return c > ' ' && c < '\x7f'; })) {
    return false;
  }
  to.method = {};
  std::copy(method.begin(), method.end(), to.method.begin());
  return is_servo_rate(to.servo_rate_hz);
}

bool read(const wire::HapticsSetup& from, HapticsSetup& to) {
  to.method_serial = from.method_serial();
  to.view_revision = from.view_revision();
  to.scene_hash = from.scene_hash();
  to.method_request = from.method_request();
  to.scene_loading = from.scene_loading();
  to.material_serial = from.material_serial();
  return read_pose(from.x_ws(), to.X_WS) && read_text(from.scene(), to.scene) && read_text(from.build(), to.build) &&
         read_text(from.method(), to.method) && read_text(from.rejection(), to.rejection);
}

bool read(const wire::SceneFacts& from, SceneFacts& to) {
  to.given_hash = from.given_hash();
  const int numbers = from.points_m_size();
  if (from.lowest_m_size() != 3 || from.highest_m_size() != 3 || numbers % 3 != 0 || numbers > 3 * static_cast<int>(to.points_m.size())) {
    return false;
  }
  to.point_count = static_cast<std::uint32_t>(numbers / 3);
  to.preparing_s = from.preparing_s();
  to.is_hand_inside = from.is_hand_inside();
  to.tool_hash = from.tool_hash();
  if (!(to.preparing_s >= 0.0F && std::isfinite(to.preparing_s))) return false;
  for (int i = 0; i < numbers / 3; ++i) {
    if (!read_point(from.points_m(), 3 * i, to.points_m[static_cast<std::size_t>(i)])) return false;
  }
  return read_point(from.lowest_m(), 0, to.lowest_m) && read_point(from.highest_m(), 0, to.highest_m);
}

bool read(const wire::ReportRequest& from, ReportRequest& to) {
  to.revision = from.revision();
  to.part = from.part();
  return read_document(from.document(), to.document);
}

bool read(const wire::ReportPart& from, ReportPart& to) {
  to.revision = from.revision();
  to.part = from.part();
  to.parts = from.parts();
  const std::string& text = from.text();
  if (text.size() > to.text.size() || to.part >= to.parts) {
    return false;
  }
  to.size = static_cast<std::uint16_t>(text.size());
  std::copy(text.begin(), text.end(), to.text.begin());
  return read_document(from.document(), to.document);
}

bool read(const wire::ViewRejected& from, ViewRejected& to) {
  to.revision = from.revision();
  return true;
}

bool read(const wire::LoopFacts& from, LoopFacts& to) {
  to.servo_rate_hz = from.servo_rate_hz();
  to.round_trip_s = from.round_trip_s();
  to.max_torque_nm = from.max_torque_nm();
  return is_servo_rate(to.servo_rate_hz) && is_amount(to.round_trip_s) && is_amount(to.max_torque_nm) &&
         read_text(from.device(), to.device);
}

bool read(const wire::Marker& from, Marker& to) {
  to.request = from.request();
  return to.request != 0 && MarkerText::is_valid(from.text()) && read_text(from.text(), to.text);
}

bool read(const wire::MarkerReply& from, MarkerReply& to) {
  to.request = from.request();
  to.sample = from.sample();
  to.status = static_cast<MarkerStatus>(from.status());
  return to.request != 0 && from.status() <= static_cast<std::uint32_t>(MarkerStatus::no_room);
}

bool read(const wire::ViewTransform& from, ViewTransform& to) {
  to.revision = from.revision();
  return read_pose(from.x_ws(), to.X_WS);
}

}  // namespace hapton
