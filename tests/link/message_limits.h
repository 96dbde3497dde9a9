#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "link/codec.h"
#include "link/messages.h"

// Checks that what a decoder accepts keeps within the limits that link/messages.h states.

namespace hapton {

inline void expect_within_limits(const ShapePart& part) {
  EXPECT_TRUE(part.total > 0 && part.total <= ShapePart::kMaxVertices);
  EXPECT_LT(part.first, part.total);
  EXPECT_EQ(part.first % ShapePart::kVerticesPerPart, 0U);
  for (const ShapePart::Displacement& one : part.displacements_m) {
    for (const float x : one) EXPECT_TRUE(std::abs(x) <= 1e9F) << "finite as well";
  }
}

inline void expect_within_limits(const MaterialChange& change) {
  EXPECT_LE(change.fields, MaterialChange::kAll);
  for (const double number : {change.stiffness_n_per_m, change.damping_ns_per_m, change.friction_static, change.friction_dynamic}) {
    EXPECT_TRUE(number >= 0.0 && number <= kMaxWireMagnitude);
  }
}

inline void expect_time(std::int64_t time_ns) { EXPECT_TRUE(time_ns >= -kMaxWireTimeNs && time_ns <= kMaxWireTimeNs) << time_ns; }

// Every message that decode accepts must satisfy the limits that link/messages.h states.
inline void expect_within_limits(const Datagram& datagram) {
  expect_time(datagram.header.send_time_ns);
  if (const auto* state = std::get_if<DeviceState>(&datagram.message)) {
    EXPECT_TRUE(state->p_WD.allFinite());
    expect_time(state->sample_time_ns);
    expect_time(state->scene_time_ns);
    EXPECT_NEAR(state->q_WT.norm(), 1.0, 1e-3);
  } else if (const auto* force = std::get_if<ForceCommand>(&datagram.message)) {
    EXPECT_TRUE(force->force_n.allFinite());
    expect_time(force->echo_sample_time_ns);
    expect_time(force->scene_time_ns);
    EXPECT_LE(force->force_n.cwiseAbs().maxCoeff(), kMaxWireMagnitude);
    EXPECT_TRUE(force->visual_offset_m.allFinite());
    EXPECT_TRUE(force->torque_nm.allFinite() && force->visual_turn.allFinite());
    EXPECT_TRUE(!force->push || (force->push->force_n.allFinite() && force->push->torque_nm.allFinite()));
  } else if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
    EXPECT_TRUE(probe->p_WD.allFinite() && probe->force_n.allFinite() && probe->visual_offset_m.allFinite());
    EXPECT_TRUE(probe->torque_nm.allFinite() && probe->visual_turn.allFinite());
    EXPECT_TRUE(!probe->push || (probe->push->force_n.allFinite() && probe->push->torque_nm.allFinite()));
    EXPECT_TRUE(std::isfinite(probe->servo_rate_hz));
    expect_time(probe->sample_time_ns);
    expect_time(probe->scene_time_ns);
  } else if (const auto* frame = std::get_if<FrameAck>(&datagram.message)) {
    expect_time(frame->echo_sample_time_ns);
  } else if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) {
    for (const float value : view->X_WS) {
      EXPECT_TRUE(std::isfinite(value));
    }
  } else if (const auto* hello = std::get_if<Hello>(&datagram.message)) {
    EXPECT_GE(static_cast<int>(hello->role), 1);
    EXPECT_LE(static_cast<int>(hello->role), 4);
  } else if (const auto* settings = std::get_if<Settings>(&datagram.message)) {
    EXPECT_TRUE(settings->servo_rate_hz == 0.0 ||
                (settings->servo_rate_hz >= kMinServoRateHz && settings->servo_rate_hz <= kMaxServoRateHz));
  } else if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) {
    for (const HapticsSetup::Text& text : {setup->scene, setup->build, setup->method, setup->rejection}) {
      EXPECT_EQ(text.back(), '\0');
      EXPECT_TRUE(std::none_of(text.begin(), text.end(), [](char c) { return (c > 0 && c < ' ') || c == '\x7f'; }));
    }
  } else if (const auto* facts = std::get_if<SceneFacts>(&datagram.message)) {
    EXPECT_LE(facts->point_count, facts->points_m.size());
    for (const SceneFacts::Point& point : facts->points_m) {
      for (const float value : point) EXPECT_LE(std::abs(value), static_cast<float>(kMaxWireMagnitude));
    }
  } else if (const auto* part = std::get_if<ReportPart>(&datagram.message)) {
    EXPECT_LE(part->size, part->text.size());
    EXPECT_LT(part->part, part->parts);
  } else if (const auto* begin = std::get_if<PatchBegin>(&datagram.message)) {
    EXPECT_TRUE(begin->origin_m.allFinite());
    EXPECT_GT(begin->step_m, 0.0);
    EXPECT_GE(begin->probe_radius_m, 0.0);
  } else if (const auto* cell = std::get_if<PatchCell>(&datagram.message)) {
    ASSERT_LE(cell->level, static_cast<std::uint32_t>(kPatchDeepestLevel));
    for (const std::uint32_t i : cell->index) EXPECT_LT(i, 1U << cell->level);
    EXPECT_LE(cell->tile_count, cell->tiles.size());
  } else if (const auto* tile = std::get_if<PatchTile>(&datagram.message)) {
    ASSERT_LE(tile->vertex_count, PatchTile::kMaxVertices);
    ASSERT_LE(tile->triangle_count, PatchTile::kMaxTriangles);
    for (std::size_t i = 0; i < std::size_t{3} * tile->triangle_count; ++i) EXPECT_LT(tile->triangles[i], tile->vertex_count);
    EXPECT_TRUE(std::isfinite(tile->stiffness_n_per_m) && tile->stiffness_n_per_m >= 0.0);
    EXPECT_LE(tile->friction_dynamic, tile->friction_static);
    EXPECT_GE(static_cast<std::int32_t>(tile->object), 0);
  } else if (const auto* status = std::get_if<PatchStatus>(&datagram.message)) {
    EXPECT_TRUE(std::isfinite(status->round_trip_s) && status->round_trip_s >= 0.0F);
    EXPECT_TRUE(std::isfinite(status->shape_s_per_vertex) && status->shape_s_per_vertex >= 0.0F);
  } else if (const auto* request = std::get_if<MaterialRequest>(&datagram.message)) {
    EXPECT_NE(request->request, 0U);
    EXPECT_EQ(request->object.back(), '\0');
    EXPECT_NE(request->change.fields, 0U);
    expect_within_limits(request->change);
  } else if (const auto* marker = std::get_if<Marker>(&datagram.message)) {
    EXPECT_NE(marker->request, 0U);
    EXPECT_EQ(marker->text.back(), '\0');
    EXPECT_TRUE(MarkerText::is_valid(marker->text.data()));
  } else if (const auto* reply = std::get_if<MarkerReply>(&datagram.message)) {
    EXPECT_LE(reply->status, MarkerStatus::no_room);
  } else if (const auto* material_state = std::get_if<MaterialState>(&datagram.message)) {
    ASSERT_LE(material_state->object_count, material_state->objects.size());
    EXPECT_EQ(material_state->rejection.back(), '\0');
    for (std::size_t i = 0; i < material_state->object_count; ++i) {
      EXPECT_GE(material_state->objects[i].object, -1);
      expect_within_limits(material_state->objects[i].change);
    }
  } else if (const auto* move_request = std::get_if<MoveRequest>(&datagram.message)) {
    EXPECT_NE(move_request->request, 0U);
    EXPECT_EQ(move_request->object.back(), '\0');
    EXPECT_GE(move_request->number, 0);
    EXPECT_TRUE(move_request->p_m || move_request->q);
    EXPECT_TRUE(!move_request->p_m || move_request->p_m->allFinite());
    EXPECT_TRUE(!move_request->q || std::abs(move_request->q->norm() - 1.0) <= 1.1e-3);
    EXPECT_TRUE(!move_request->over_s || (*move_request->over_s > 0.0 && *move_request->over_s <= MoveRequest::kMaxSeconds));
  } else if (const auto* move_reply = std::get_if<MoveReply>(&datagram.message)) {
    EXPECT_NE(move_reply->request, 0U);
    EXPECT_EQ(move_reply->rejection.back(), '\0');
    EXPECT_TRUE(std::isfinite(move_reply->over_s) && move_reply->over_s >= 0.0);
  } else if (const auto* move = std::get_if<ObjectMove>(&datagram.message)) {
    EXPECT_NE(move->source, 0U);
    EXPECT_GE(move->object, 0);
    EXPECT_GE(move->start_ns, 0);
    EXPECT_GE(move->end_ns, move->start_ns);
    expect_time(move->end_ns);
    EXPECT_TRUE(move->from_p_m.allFinite() && move->to_p_m.allFinite());
    EXPECT_NEAR(move->from_q.norm(), 1.0, 1.1e-3);
    EXPECT_NEAR(move->to_q.norm(), 1.0, 1.1e-3);
  } else if (const auto* carves = std::get_if<Carves>(&datagram.message)) {
    EXPECT_NE(carves->source, 0U);
    ASSERT_LE(carves->count, Carves::kMax);
    EXPECT_EQ(carves->count == 0, carves->first == 0);
    EXPECT_LE(std::uint64_t{carves->first} + carves->count, std::uint64_t{carves->newest} + 1);
    for (std::size_t n = 0; n < carves->count; ++n) {
      const Carves::One& one = carves->carves[n];
      if (one.is_undo()) {
        EXPECT_EQ(one.object, -1);
        EXPECT_LE(one.undone_first, one.undone_last);
        EXPECT_LT(one.undone_last, carves->first + n);
        continue;
      }
      EXPECT_GE(one.object, 0);
      const Vec3 from(one.from_m[0], one.from_m[1], one.from_m[2]);
      const Vec3 to(one.to_m[0], one.to_m[1], one.to_m[2]);
      EXPECT_TRUE((to - from).norm() <= 1000.0) << "finite as well";
      EXPECT_TRUE(one.radius_m > 0.0F && one.radius_m <= 1000.0F);
    }
  } else if (const auto* carve_status = std::get_if<CarveStatus>(&datagram.message)) {
    EXPECT_NE(carve_status->source, 0U);
  } else if (const auto* undo = std::get_if<CarveUndo>(&datagram.message)) {
    EXPECT_TRUE(undo->source != 0 && undo->serial != 0);
  } else if (const auto* shape_request = std::get_if<ShapeRequest>(&datagram.message)) {
    EXPECT_TRUE(shape_request->stream != 0 && shape_request->shape != 0);
    EXPECT_TRUE(shape_request->over_s >= 0.0 && shape_request->over_s <= ShapeRequest::kMaxSeconds);
    EXPECT_GE(shape_request->number, 0);
    expect_within_limits(shape_request->part);
  } else if (const auto* shape = std::get_if<ObjectShape>(&datagram.message)) {
    EXPECT_TRUE(shape->source != 0 && shape->serial != 0 && shape->object >= 0);
    expect_within_limits(shape->part);
  } else if (const auto* start = std::get_if<ShapeStart>(&datagram.message)) {
    EXPECT_TRUE(start->source != 0 && start->object >= 0);
    EXPECT_TRUE(start->serial == 0 ? start->before == 0 : start->before < start->serial);
    EXPECT_TRUE(start->total > 0 && start->total <= ShapePart::kMaxVertices);
    EXPECT_TRUE(start->start_ns >= 0 && start->end_ns >= start->start_ns);
    expect_time(start->end_ns);
  } else if (const auto* shape_status = std::get_if<ShapeStatus>(&datagram.message)) {
    EXPECT_TRUE(shape_status->source != 0 && shape_status->serial != 0 && shape_status->object >= 0);
    EXPECT_EQ(shape_status->first % ShapePart::kVerticesPerPart, 0U);
    EXPECT_LT(shape_status->first, ShapePart::kMaxVertices);
  } else if (const auto* shape_reply = std::get_if<ShapeReply>(&datagram.message)) {
    EXPECT_TRUE(shape_reply->stream != 0 && shape_reply->shape != 0 && shape_reply->over_s >= 0.0);
  } else if (const auto* pose = std::get_if<ObjectPose>(&datagram.message)) {
    EXPECT_NE(pose->serial, 0U);
    EXPECT_GE(pose->object, 0);
    EXPECT_TRUE(pose->p_m.allFinite());
    EXPECT_NEAR(pose->q.norm(), 1.0, 1.1e-3);
  }
}

}  // namespace hapton
