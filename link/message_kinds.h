#pragma once

#include <cstddef>
#include <tuple>
#include <variant>

#include "hapton.pb.h"
#include "link/messages.h"

// The table of message kinds: one line each, those that come most often first. The number of kinds, and what the codec does with each, come
// from it. Used by codec.cpp alone.
namespace hapton {

// One kind: its struct Ours (messages.h), its message Theirs (proto/hapton.proto), and its functions in an Envelope.
template <class OursType, class TheirsType>
struct MessageKind {
  using Ours = OursType;
  using Theirs = TheirsType;
  bool (wire::Envelope::*has)() const;
  const Theirs& (wire::Envelope::*get)() const;
  Theirs* (wire::Envelope::*make)();
};

inline constexpr std::tuple kMessageKinds{
    MessageKind<DeviceState, wire::DeviceState>{&wire::Envelope::has_device_state, &wire::Envelope::device_state,
                                                &wire::Envelope::mutable_device_state},
    MessageKind<ForceCommand, wire::ForceCommand>{&wire::Envelope::has_force_command, &wire::Envelope::force_command,
                                                  &wire::Envelope::mutable_force_command},
    MessageKind<ProbeState, wire::ProbeState>{&wire::Envelope::has_probe_state, &wire::Envelope::probe_state,
                                              &wire::Envelope::mutable_probe_state},
    MessageKind<ViewTransform, wire::ViewTransform>{&wire::Envelope::has_view_transform, &wire::Envelope::view_transform,
                                                    &wire::Envelope::mutable_view_transform},
    MessageKind<FrameAck, wire::FrameAck>{&wire::Envelope::has_drawn, &wire::Envelope::drawn, &wire::Envelope::mutable_drawn},
    MessageKind<Hello, wire::Hello>{&wire::Envelope::has_hello, &wire::Envelope::hello, &wire::Envelope::mutable_hello},
    MessageKind<Welcome, wire::Welcome>{&wire::Envelope::has_welcome, &wire::Envelope::welcome, &wire::Envelope::mutable_welcome},
    MessageKind<HandTarget, wire::HandTarget>{&wire::Envelope::has_hand_target, &wire::Envelope::hand_target,
                                              &wire::Envelope::mutable_hand_target},
    MessageKind<Settings, wire::Settings>{&wire::Envelope::has_settings, &wire::Envelope::settings, &wire::Envelope::mutable_settings},
    MessageKind<HapticsSetup, wire::HapticsSetup>{&wire::Envelope::has_haptics_setup, &wire::Envelope::haptics_setup,
                                                  &wire::Envelope::mutable_haptics_setup},
    MessageKind<ReportRequest, wire::ReportRequest>{&wire::Envelope::has_report_request, &wire::Envelope::report_request,
                                                    &wire::Envelope::mutable_report_request},
    MessageKind<ReportPart, wire::ReportPart>{&wire::Envelope::has_report_part, &wire::Envelope::report_part,
                                              &wire::Envelope::mutable_report_part},
    MessageKind<SceneFacts, wire::SceneFacts>{&wire::Envelope::has_scene_facts, &wire::Envelope::scene_facts,
                                              &wire::Envelope::mutable_scene_facts},
    MessageKind<ViewRejected, wire::ViewRejected>{&wire::Envelope::has_view_rejected, &wire::Envelope::view_rejected,
                                                  &wire::Envelope::mutable_view_rejected},
    MessageKind<PatchTile, wire::PatchTile>{&wire::Envelope::has_patch_tile, &wire::Envelope::patch_tile,
                                            &wire::Envelope::mutable_patch_tile},
    MessageKind<PatchCell, wire::PatchCell>{&wire::Envelope::has_patch_cell, &wire::Envelope::patch_cell,
                                            &wire::Envelope::mutable_patch_cell},
    MessageKind<PatchBegin, wire::PatchBegin>{&wire::Envelope::has_patch_begin, &wire::Envelope::patch_begin,
                                              &wire::Envelope::mutable_patch_begin},
    MessageKind<PatchStatus, wire::PatchStatus>{&wire::Envelope::has_patch_status, &wire::Envelope::patch_status,
                                                &wire::Envelope::mutable_patch_status},
    MessageKind<LoopFacts, wire::LoopFacts>{&wire::Envelope::has_loop_facts, &wire::Envelope::loop_facts,
                                            &wire::Envelope::mutable_loop_facts},
    MessageKind<MaterialRequest, wire::MaterialRequest>{&wire::Envelope::has_material_request, &wire::Envelope::material_request,
                                                        &wire::Envelope::mutable_material_request},
    MessageKind<MaterialState, wire::MaterialState>{&wire::Envelope::has_material_state, &wire::Envelope::material_state,
                                                    &wire::Envelope::mutable_material_state},
    MessageKind<ObjectPose, wire::ObjectPose>{&wire::Envelope::has_object_pose, &wire::Envelope::object_pose,
                                              &wire::Envelope::mutable_object_pose},
    MessageKind<Marker, wire::Marker>{&wire::Envelope::has_marker, &wire::Envelope::marker, &wire::Envelope::mutable_marker},
    MessageKind<MarkerReply, wire::MarkerReply>{&wire::Envelope::has_marker_reply, &wire::Envelope::marker_reply,
                                                &wire::Envelope::mutable_marker_reply},
    MessageKind<MoveRequest, wire::MoveRequest>{&wire::Envelope::has_move_request, &wire::Envelope::move_request,
                                                &wire::Envelope::mutable_move_request},
    MessageKind<MoveReply, wire::MoveReply>{&wire::Envelope::has_move_reply, &wire::Envelope::move_reply,
                                            &wire::Envelope::mutable_move_reply},
    MessageKind<ObjectMove, wire::ObjectMove>{&wire::Envelope::has_object_move, &wire::Envelope::object_move,
                                              &wire::Envelope::mutable_object_move},
    MessageKind<Carves, wire::Carves>{&wire::Envelope::has_carves, &wire::Envelope::carves, &wire::Envelope::mutable_carves},
    MessageKind<CarveStatus, wire::CarveStatus>{&wire::Envelope::has_carve_status, &wire::Envelope::carve_status,
                                                &wire::Envelope::mutable_carve_status},
    MessageKind<PatchBody, wire::PatchBody>{&wire::Envelope::has_patch_body, &wire::Envelope::patch_body,
                                            &wire::Envelope::mutable_patch_body},
    MessageKind<PatchMaterial, wire::PatchMaterial>{&wire::Envelope::has_patch_material, &wire::Envelope::patch_material,
                                                    &wire::Envelope::mutable_patch_material},
    MessageKind<CarveUndo, wire::CarveUndo>{&wire::Envelope::has_carve_undo, &wire::Envelope::carve_undo,
                                            &wire::Envelope::mutable_carve_undo},
    MessageKind<ShapeRequest, wire::ShapeRequest>{&wire::Envelope::has_shape_request, &wire::Envelope::shape_request,
                                                  &wire::Envelope::mutable_shape_request},
    MessageKind<ShapeReply, wire::ShapeReply>{&wire::Envelope::has_shape_reply, &wire::Envelope::shape_reply,
                                              &wire::Envelope::mutable_shape_reply},
    MessageKind<ObjectShape, wire::ObjectShape>{&wire::Envelope::has_object_shape, &wire::Envelope::object_shape,
                                                &wire::Envelope::mutable_object_shape},
    MessageKind<ShapeStart, wire::ShapeStart>{&wire::Envelope::has_shape_start, &wire::Envelope::shape_start,
                                              &wire::Envelope::mutable_shape_start},
    MessageKind<ShapeStatus, wire::ShapeStatus>{&wire::Envelope::has_shape_status, &wire::Envelope::shape_status,
                                                &wire::Envelope::mutable_shape_status},
    MessageKind<PatchDeformation, wire::PatchDeformation>{&wire::Envelope::has_patch_deformation, &wire::Envelope::patch_deformation,
                                                          &wire::Envelope::mutable_patch_deformation},
    MessageKind<PatchDisplacements, wire::PatchDisplacements>{
        &wire::Envelope::has_patch_displacements, &wire::Envelope::patch_displacements, &wire::Envelope::mutable_patch_displacements},
    MessageKind<PatchStream, wire::PatchStream>{&wire::Envelope::has_patch_stream, &wire::Envelope::patch_stream,
                                                &wire::Envelope::mutable_patch_stream},
    MessageKind<PatchEffects, wire::PatchEffects>{&wire::Envelope::has_patch_effects, &wire::Envelope::patch_effects,
                                                  &wire::Envelope::mutable_patch_effects},
    MessageKind<Bye, wire::Bye>{&wire::Envelope::has_bye, &wire::Envelope::bye, &wire::Envelope::mutable_bye},
};
inline constexpr std::size_t kKindCount = std::tuple_size_v<decltype(kMessageKinds)>;
static_assert(kKindCount == std::variant_size_v<Message>, "each kind of Message has a line in kMessageKinds");
// Fields 1 to 5 of an Envelope are its header, the others one kind each, from 16 on.
static_assert(wire::Envelope::kPatchEffectsFieldNumber == 15 + kKindCount, "the last kind of hapton.proto, and its line in kMessageKinds");

// Calls visit with each kind until one returns true.
template <class Visit>
bool visit_kinds(Visit&& visit) {
  return std::apply([&](const auto&... kind) { return (visit(kind) || ...); }, kMessageKinds);
}

}  // namespace hapton
