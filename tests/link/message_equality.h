#pragma once

// Whether two messages are the same, field by field.
#include <gtest/gtest.h>

#include <tuple>
#include <type_traits>
#include <variant>

#include "link/messages.h"

namespace hapton {

inline void expect_equal(const Hello& a, const Hello& b) { EXPECT_EQ(a.role, b.role); }
inline void expect_equal(const Welcome& a, const Welcome& b) {
  EXPECT_EQ(a.accepted, b.accepted);
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
}
inline void expect_equal(const Bye&, const Bye&) {}
inline void expect_equal(const DeviceState& a, const DeviceState& b) {
  EXPECT_EQ(a.sample, b.sample);
  EXPECT_EQ(a.sample_time_ns, b.sample_time_ns);
  EXPECT_EQ(a.p_WD, b.p_WD);
  EXPECT_EQ(a.q_WT.coeffs(), b.q_WT.coeffs());
  EXPECT_EQ(a.buttons, b.buttons);
  EXPECT_EQ(a.is_resumed, b.is_resumed);
  EXPECT_EQ(a.p_WP, b.p_WP);
  EXPECT_EQ(a.scene_time_ns, b.scene_time_ns);
}
inline void expect_equal(const ForceCommand& a, const ForceCommand& b) {
  EXPECT_EQ(a.echo_sample, b.echo_sample);
  EXPECT_EQ(a.echo_sample_time_ns, b.echo_sample_time_ns);
  EXPECT_EQ(a.force_n, b.force_n);
  EXPECT_EQ(a.visual_offset_m, b.visual_offset_m);
  EXPECT_EQ(a.contact, b.contact);
  EXPECT_EQ(a.compute_ns, b.compute_ns);
  EXPECT_EQ(a.skipped_samples, b.skipped_samples);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.method_serial, b.method_serial);
  EXPECT_EQ(a.replied_before, b.replied_before);
  EXPECT_EQ(a.material_serial, b.material_serial);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.torque_nm, b.torque_nm);
  EXPECT_EQ(a.visual_turn, b.visual_turn);
  EXPECT_EQ(a.push, b.push);
  EXPECT_EQ(a.haptons, b.haptons);
  EXPECT_EQ(a.held_offset_m, b.held_offset_m);
  EXPECT_EQ(a.scene_time_ns, b.scene_time_ns);
  EXPECT_EQ(a.move_serial, b.move_serial);
  EXPECT_EQ(a.carve_serial, b.carve_serial);
  EXPECT_EQ(a.shape_serial, b.shape_serial);
}
inline void expect_equal(const MaterialChange& a, const MaterialChange& b) {
  EXPECT_EQ(a.fields, b.fields);
  EXPECT_EQ(a.stiffness_n_per_m, b.stiffness_n_per_m);
  EXPECT_EQ(a.damping_ns_per_m, b.damping_ns_per_m);
  EXPECT_EQ(a.friction_static, b.friction_static);
  EXPECT_EQ(a.friction_dynamic, b.friction_dynamic);
}
inline void expect_equal(const MaterialRequest& a, const MaterialRequest& b) {
  EXPECT_EQ(a.request, b.request);
  EXPECT_EQ(a.object, b.object);
  expect_equal(a.change, b.change);
}
inline void expect_equal(const MaterialState& a, const MaterialState& b) {
  EXPECT_EQ(a.serial, b.serial);
  EXPECT_EQ(a.request, b.request);
  EXPECT_EQ(a.rejection, b.rejection);
  ASSERT_EQ(a.object_count, b.object_count);
  for (std::size_t i = 0; i < a.object_count; ++i) {
    EXPECT_EQ(a.objects[i].object, b.objects[i].object);
    expect_equal(a.objects[i].change, b.objects[i].change);
  }
}
inline void expect_equal(const Marker& a, const Marker& b) { EXPECT_EQ(std::tie(a.request, a.text), std::tie(b.request, b.text)); }
inline void expect_equal(const MarkerReply& a, const MarkerReply& b) {
  EXPECT_EQ(std::tie(a.request, a.sample, a.status), std::tie(b.request, b.sample, b.status));
}
inline void expect_equal(const MoveRequest& a, const MoveRequest& b) {
  EXPECT_EQ(std::tie(a.request, a.object, a.number, a.over_s), std::tie(b.request, b.object, b.number, b.over_s));
  EXPECT_EQ(a.p_m, b.p_m);
  ASSERT_EQ(a.q.has_value(), b.q.has_value());
  EXPECT_TRUE(!a.q || a.q->coeffs() == b.q->coeffs());
}
inline void expect_equal(const MoveReply& a, const MoveReply& b) {
  EXPECT_EQ(std::tie(a.request, a.rejection, a.object, a.over_s, a.serial), std::tie(b.request, b.rejection, b.object, b.over_s, b.serial));
}
inline void expect_equal(const ObjectMove& a, const ObjectMove& b) {
  EXPECT_EQ(std::tie(a.source, a.serial, a.object, a.start_ns, a.end_ns, a.name),
            std::tie(b.source, b.serial, b.object, b.start_ns, b.end_ns, b.name));
  EXPECT_EQ(a.from_p_m, b.from_p_m);
  EXPECT_EQ(a.from_q.coeffs(), b.from_q.coeffs());
  EXPECT_EQ(a.to_p_m, b.to_p_m);
  EXPECT_EQ(a.to_q.coeffs(), b.to_q.coeffs());
}
inline void expect_equal(const Carves& a, const Carves& b) {
  ASSERT_EQ(std::tie(a.source, a.newest, a.first, a.count), std::tie(b.source, b.newest, b.first, b.count));
  for (std::size_t n = 0; n < a.count; ++n) {
    const Carves::One& one = a.carves[n];
    const Carves::One& other = b.carves[n];
    EXPECT_EQ(std::tie(one.object, one.from_m, one.to_m, one.radius_m), std::tie(other.object, other.from_m, other.to_m, other.radius_m));
    EXPECT_EQ(std::tie(one.begins, one.undone_first, one.undone_last), std::tie(other.begins, other.undone_first, other.undone_last));
  }
}
inline void expect_equal(const CarveUndo& a, const CarveUndo& b) { EXPECT_EQ(std::tie(a.source, a.serial), std::tie(b.source, b.serial)); }
inline void expect_equal(const ShapePart& a, const ShapePart& b) {
  EXPECT_EQ(std::tie(a.total, a.first, a.displacements_m), std::tie(b.total, b.first, b.displacements_m));
}
inline void expect_equal(const ShapeRequest& a, const ShapeRequest& b) {
  EXPECT_EQ(std::tie(a.stream, a.shape, a.object, a.number, a.over_s), std::tie(b.stream, b.shape, b.object, b.number, b.over_s));
  expect_equal(a.part, b.part);
}
inline void expect_equal(const ShapeReply& a, const ShapeReply& b) {
  EXPECT_EQ(std::tie(a.stream, a.shape, a.rejection, a.object, a.over_s, a.serial),
            std::tie(b.stream, b.shape, b.rejection, b.object, b.over_s, b.serial));
}
inline void expect_equal(const ObjectShape& a, const ObjectShape& b) {
  EXPECT_EQ(std::tie(a.source, a.serial, a.object), std::tie(b.source, b.serial, b.object));
  expect_equal(a.part, b.part);
}
inline void expect_equal(const ShapeStart& a, const ShapeStart& b) {
  EXPECT_EQ(std::tie(a.source, a.serial, a.before, a.object, a.total, a.start_ns, a.end_ns),
            std::tie(b.source, b.serial, b.before, b.object, b.total, b.start_ns, b.end_ns));
}
inline void expect_equal(const ShapeStatus& a, const ShapeStatus& b) {
  EXPECT_EQ(std::tie(a.source, a.serial, a.object, a.first, a.count), std::tie(b.source, b.serial, b.object, b.first, b.count));
}
inline void expect_equal(const CarveStatus& a, const CarveStatus& b) {
  EXPECT_EQ(std::tie(a.source, a.complete), std::tie(b.source, b.complete));
}
inline void expect_equal(const ViewTransform& a, const ViewTransform& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.X_WS, b.X_WS);
}
inline void expect_equal(const ProbeState& a, const ProbeState& b) {
  EXPECT_EQ(a.sample, b.sample);
  EXPECT_EQ(a.sample_time_ns, b.sample_time_ns);
  EXPECT_EQ(a.p_WD, b.p_WD);
  EXPECT_EQ(a.q_WT.coeffs(), b.q_WT.coeffs());
  EXPECT_EQ(a.visual_offset_m, b.visual_offset_m);
  EXPECT_EQ(a.force_n, b.force_n);
  EXPECT_EQ(a.contact, b.contact);
  EXPECT_EQ(a.buttons, b.buttons);
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
  EXPECT_EQ(a.round_trip_p50_us, b.round_trip_p50_us);
  EXPECT_EQ(a.round_trip_p99_us, b.round_trip_p99_us);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.energy_percent, b.energy_percent);
  EXPECT_EQ(a.force_limit_n, b.force_limit_n);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.torque_nm, b.torque_nm);
  EXPECT_EQ(a.visual_turn, b.visual_turn);
  EXPECT_EQ(a.push, b.push);
  EXPECT_EQ(a.haptons, b.haptons);
  EXPECT_EQ(a.scene_time_ns, b.scene_time_ns);
}
inline void expect_equal(const FrameAck& a, const FrameAck& b) {
  EXPECT_EQ(a.echo_sample, b.echo_sample);
  EXPECT_EQ(a.echo_sample_time_ns, b.echo_sample_time_ns);
  EXPECT_EQ(a.frame_rate_hz, b.frame_rate_hz);
  EXPECT_EQ(a.held_ns, b.held_ns);
  EXPECT_EQ(a.rest_ns, b.rest_ns);
  EXPECT_EQ(a.unchanged, b.unchanged);
  EXPECT_EQ(a.every_sample, b.every_sample);
}
inline void expect_equal(const HandTarget& a, const HandTarget& b) {
  EXPECT_EQ(a.active, b.active);
  EXPECT_EQ(a.p_WH, b.p_WH);
  EXPECT_EQ(a.buttons, b.buttons);
  EXPECT_EQ(a.turn_rad, b.turn_rad);
}
inline void expect_equal(const ObjectPose& a, const ObjectPose& b) {
  EXPECT_EQ(a.serial, b.serial);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.is_held, b.is_held);
  EXPECT_EQ(a.p_m, b.p_m);
  EXPECT_EQ(a.q.coeffs(), b.q.coeffs());
}
inline void expect_equal(const Settings& a, const Settings& b) {
  EXPECT_EQ(a.servo_rate_hz, b.servo_rate_hz);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.report_now, b.report_now);
  EXPECT_EQ(a.reset_faults, b.reset_faults);
  EXPECT_EQ(a.method_request, b.method_request);
}
inline void expect_equal(const HapticsSetup& a, const HapticsSetup& b) {
  EXPECT_EQ(a.method_serial, b.method_serial);
  EXPECT_EQ(a.view_revision, b.view_revision);
  EXPECT_EQ(a.X_WS, b.X_WS);
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(a.scene, b.scene);
  EXPECT_EQ(a.build, b.build);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.method_request, b.method_request);
  EXPECT_EQ(a.rejection, b.rejection);
  EXPECT_EQ(a.scene_loading, b.scene_loading);
  EXPECT_EQ(a.material_serial, b.material_serial);
}

inline void expect_equal(const ReportRequest& a, const ReportRequest& b) {
  EXPECT_EQ(a.document, b.document);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.part, b.part);
}
inline void expect_equal(const ReportPart& a, const ReportPart& b) {
  EXPECT_EQ(a.document, b.document);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.parts, b.parts);
  EXPECT_EQ(std::string_view(a.text.data(), a.size), std::string_view(b.text.data(), b.size));
}
inline void expect_equal(const SceneFacts& a, const SceneFacts& b) {
  EXPECT_EQ(a.given_hash, b.given_hash);
  EXPECT_EQ(a.lowest_m, b.lowest_m);
  EXPECT_EQ(a.highest_m, b.highest_m);
  EXPECT_EQ(a.point_count, b.point_count);
  EXPECT_EQ(a.points_m, b.points_m);
  EXPECT_EQ(a.preparing_s, b.preparing_s);
  EXPECT_EQ(a.is_hand_inside, b.is_hand_inside);
  EXPECT_EQ(a.tool_hash, b.tool_hash);
}

inline void expect_equal(const ViewRejected& a, const ViewRejected& b) { EXPECT_EQ(a.revision, b.revision); }
inline void expect_equal(const LoopFacts& a, const LoopFacts& b) {
  EXPECT_EQ(std::tie(a.device, a.servo_rate_hz, a.round_trip_s, a.max_torque_nm),
            std::tie(b.device, b.servo_rate_hz, b.round_trip_s, b.max_torque_nm));
}
inline void expect_equal(const PatchBegin& a, const PatchBegin& b) {
  EXPECT_EQ(
      std::tie(a.epoch, a.serial, a.step_m, a.probe_radius_m, a.scene_hash, a.body_count, a.request, a.method_serial, a.effect_bytes),
      std::tie(b.epoch, b.serial, b.step_m, b.probe_radius_m, b.scene_hash, b.body_count, b.request, b.method_serial, b.effect_bytes));
  EXPECT_EQ(a.origin_m, b.origin_m);
}
inline void expect_equal(const PatchCell& a, const PatchCell& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.level, a.index, a.empty_children, a.tile_count, a.tiles, a.body),
            std::tie(b.epoch, b.serial, b.level, b.index, b.empty_children, b.tile_count, b.tiles, b.body));
}
inline void expect_equal(const PatchTile& a, const PatchTile& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.tile, a.object, a.stiffness_n_per_m, a.damping_ns_per_m, a.friction_static, a.friction_dynamic,
                     a.two_sided, a.vertex_count, a.triangle_count, a.vertices, a.triangles),
            std::tie(b.epoch, b.serial, b.tile, b.object, b.stiffness_n_per_m, b.damping_ns_per_m, b.friction_static, b.friction_dynamic,
                     b.two_sided, b.vertex_count, b.triangle_count, b.vertices, b.triangles));
}
inline void expect_equal(const PatchStatus& a, const PatchStatus& b) {
  EXPECT_EQ(std::tie(a.is_wanted, a.epoch, a.newest_serial, a.received, a.round_trip_s, a.newest_move, a.moves_received, a.request,
                     a.knows_effects, a.shape_s_per_vertex),
            std::tie(b.is_wanted, b.epoch, b.newest_serial, b.received, b.round_trip_s, b.newest_move, b.moves_received, b.request,
                     b.knows_effects, b.shape_s_per_vertex));
}
inline void expect_equal(const PatchBody& a, const PatchBody& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.body, a.motion, a.deforms, a.lowest, a.highest, a.radius_m, a.object, a.move_serial, a.loops,
                     a.all_keys, a.first_key, a.key_count),
            std::tie(b.epoch, b.serial, b.body, b.motion, b.deforms, b.lowest, b.highest, b.radius_m, b.object, b.move_serial, b.loops,
                     b.all_keys, b.first_key, b.key_count));
  EXPECT_EQ(a.pivot_m, b.pivot_m);
  for (std::size_t n = 0; n < a.keys.size(); ++n) EXPECT_EQ(a.keys[n], b.keys[n]) << n;
}
inline void expect_equal(const PatchMaterial& a, const PatchMaterial& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.object, a.stiffness_n_per_m, a.damping_ns_per_m, a.friction_static, a.friction_dynamic),
            std::tie(b.epoch, b.serial, b.object, b.stiffness_n_per_m, b.damping_ns_per_m, b.friction_static, b.friction_dynamic));
}
inline void expect_equal(const PatchDeformation& a, const PatchDeformation& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.body, a.first_tile, a.tile_count, a.displaced_count, a.target_count, a.loops, a.all_keys,
                     a.first_key, a.key_count, a.keys),
            std::tie(b.epoch, b.serial, b.body, b.first_tile, b.tile_count, b.displaced_count, b.target_count, b.loops, b.all_keys,
                     b.first_key, b.key_count, b.keys));
}
inline void expect_equal(const PatchDisplacements& a, const PatchDisplacements& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.tile, a.target, a.vertex_count, a.displacements_m),
            std::tie(b.epoch, b.serial, b.tile, b.target, b.vertex_count, b.displacements_m));
}
inline void expect_equal(const PatchStream& a, const PatchStream& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.body, a.first_tile, a.tile_count, a.object, a.total, a.reach_m, a.shape_serial, a.tile,
                     a.vertex_count, a.vertices),
            std::tie(b.epoch, b.serial, b.body, b.first_tile, b.tile_count, b.object, b.total, b.reach_m, b.shape_serial, b.tile,
                     b.vertex_count, b.vertices));
  EXPECT_EQ(a.to_scene, b.to_scene);
}

inline void expect_equal(const PatchEffects& a, const PatchEffects& b) {
  EXPECT_EQ(std::tie(a.epoch, a.serial, a.part, a.byte_count, a.bytes), std::tie(b.epoch, b.serial, b.part, b.byte_count, b.bytes));
}

inline void expect_equal(const Datagram& a, const Datagram& b) {
  EXPECT_EQ(a.header.session, b.header.session);
  EXPECT_EQ(a.header.sender, b.header.sender);
  EXPECT_EQ(a.header.sequence, b.header.sequence);
  EXPECT_EQ(a.header.send_time_ns, b.header.send_time_ns);
  ASSERT_EQ(a.message.index(), b.message.index());
  std::visit([&](const auto& m) { expect_equal(m, std::get<std::decay_t<decltype(m)>>(b.message)); }, a.message);
}

}  // namespace hapton
