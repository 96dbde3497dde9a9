#pragma once

#include "link/messages.h"

// Converts each message to and from its form in proto/hapton.proto. Used by codec.cpp alone, which states the contract.
namespace hapton {

namespace wire {
class Hello;
class Welcome;
class Bye;
class DeviceState;
class ForceCommand;
class ViewTransform;
class ProbeState;
class FrameAck;
class HandTarget;
class Settings;
class HapticsSetup;
class SceneFacts;
class ReportRequest;
class ReportPart;
class ViewRejected;
class LoopFacts;
class PatchBegin;
class PatchCell;
class PatchTile;
class PatchBody;
class PatchMaterial;
class PatchDeformation;
class PatchDisplacements;
class PatchStream;
class PatchEffects;
class PatchStatus;
class MaterialRequest;
class MaterialState;
class ObjectPose;
class Marker;
class MarkerReply;
class MoveRequest;
class MoveReply;
class ObjectMove;
class Carves;
class CarveStatus;
class CarveUndo;
class ShapeRequest;
class ShapeReply;
class ObjectShape;
class ShapeStart;
class ShapeStatus;
}  // namespace wire

void write(const Hello& from, wire::Hello& to);
void write(const Welcome& from, wire::Welcome& to);
void write(const Bye&, wire::Bye&);
void write(const DeviceState& from, wire::DeviceState& to);
void write(const ForceCommand& from, wire::ForceCommand& to);
void write(const ViewTransform& from, wire::ViewTransform& to);
void write(const ProbeState& from, wire::ProbeState& to);
void write(const FrameAck& from, wire::FrameAck& to);
void write(const HandTarget& from, wire::HandTarget& to);
void write(const Settings& from, wire::Settings& to);
void write(const HapticsSetup& from, wire::HapticsSetup& to);
void write(const SceneFacts& from, wire::SceneFacts& to);
void write(const ReportRequest& from, wire::ReportRequest& to);
void write(const ReportPart& from, wire::ReportPart& to);
void write(const ViewRejected& from, wire::ViewRejected& to);
void write(const LoopFacts& from, wire::LoopFacts& to);
void write(const PatchBegin& from, wire::PatchBegin& to);
void write(const PatchCell& from, wire::PatchCell& to);
void write(const PatchTile& from, wire::PatchTile& to);
void write(const PatchBody& from, wire::PatchBody& to);
void write(const PatchMaterial& from, wire::PatchMaterial& to);
void write(const PatchDeformation& from, wire::PatchDeformation& to);
void write(const PatchDisplacements& from, wire::PatchDisplacements& to);
void write(const PatchStream& from, wire::PatchStream& to);
void write(const PatchEffects& from, wire::PatchEffects& to);
void write(const PatchStatus& from, wire::PatchStatus& to);
void write(const MaterialRequest& from, wire::MaterialRequest& to);
void write(const MaterialState& from, wire::MaterialState& to);
void write(const ObjectPose& from, wire::ObjectPose& to);
void write(const Marker& from, wire::Marker& to);
void write(const MarkerReply& from, wire::MarkerReply& to);
void write(const MoveRequest& from, wire::MoveRequest& to);
void write(const MoveReply& from, wire::MoveReply& to);
void write(const ObjectMove& from, wire::ObjectMove& to);
void write(const Carves& from, wire::Carves& to);
void write(const CarveStatus& from, wire::CarveStatus& to);
void write(const CarveUndo& from, wire::CarveUndo& to);
void write(const ShapeRequest& from, wire::ShapeRequest& to);
void write(const ShapeReply& from, wire::ShapeReply& to);
void write(const ObjectShape& from, wire::ObjectShape& to);
void write(const ShapeStart& from, wire::ShapeStart& to);
void write(const ShapeStatus& from, wire::ShapeStatus& to);

// False for a value that the contract rules out; `to` is then not to be used.
bool read(const wire::Hello& from, Hello& to);
bool read(const wire::Welcome& from, Welcome& to);
bool read(const wire::Bye&, Bye&);
bool read(const wire::DeviceState& from, DeviceState& to);
bool read(const wire::ForceCommand& from, ForceCommand& to);
bool read(const wire::ProbeState& from, ProbeState& to);
bool read(const wire::FrameAck& from, FrameAck& to);
bool read(const wire::HandTarget& from, HandTarget& to);
bool read(const wire::Settings& from, Settings& to);
bool read(const wire::HapticsSetup& from, HapticsSetup& to);
bool read(const wire::SceneFacts& from, SceneFacts& to);
bool read(const wire::ReportRequest& from, ReportRequest& to);
bool read(const wire::ReportPart& from, ReportPart& to);
bool read(const wire::ViewRejected& from, ViewRejected& to);
bool read(const wire::LoopFacts& from, LoopFacts& to);
bool read(const wire::PatchBegin& from, PatchBegin& to);
bool read(const wire::PatchCell& from, PatchCell& to);
bool read(const wire::PatchTile& from, PatchTile& to);
bool read(const wire::PatchBody& from, PatchBody& to);
bool read(const wire::PatchMaterial& from, PatchMaterial& to);
bool read(const wire::PatchDeformation& from, PatchDeformation& to);
bool read(const wire::PatchDisplacements& from, PatchDisplacements& to);
bool read(const wire::PatchStream& from, PatchStream& to);
bool read(const wire::PatchEffects& from, PatchEffects& to);
bool read(const wire::PatchStatus& from, PatchStatus& to);
bool read(const wire::MaterialRequest& from, MaterialRequest& to);
bool read(const wire::MaterialState& from, MaterialState& to);
bool read(const wire::ObjectPose& from, ObjectPose& to);
bool read(const wire::Marker& from, Marker& to);
bool read(const wire::MarkerReply& from, MarkerReply& to);
bool read(const wire::MoveRequest& from, MoveRequest& to);
bool read(const wire::MoveReply& from, MoveReply& to);
bool read(const wire::ObjectMove& from, ObjectMove& to);
bool read(const wire::Carves& from, Carves& to);
bool read(const wire::CarveStatus& from, CarveStatus& to);
bool read(const wire::CarveUndo& from, CarveUndo& to);
bool read(const wire::ShapeRequest& from, ShapeRequest& to);
bool read(const wire::ShapeReply& from, ShapeReply& to);
bool read(const wire::ObjectShape& from, ObjectShape& to);
bool read(const wire::ShapeStart& from, ShapeStart& to);
bool read(const wire::ShapeStatus& from, ShapeStatus& to);
bool read(const wire::ViewTransform& from, ViewTransform& to);

}  // namespace hapton
