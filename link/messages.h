#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "core/math/keyframe_motion.h"
#include "core/math/types.h"
#include "link/marker_text.h"
#include "link/patch_messages.h"
#include "link/shape_messages.h"

namespace hapton {

// The messages between the nodes. Units SI, frame W unless named; times are the sender's CLOCK_MONOTONIC in ns.
// Frames and points (docs/frames.md): W world, S static scene, D device point, T stylus, P proxy, H goal of the simulated hand.
// A node needs only the hub's address (io_node): every message goes to the hub or comes from it.

enum class NodeRole : std::uint8_t { io = 1, haptics = 2, vision = 3, tool = 4 };

// node -> hub, every 100 ms: "I am here". The hub replies to each with a Welcome.
struct Hello {
  NodeRole role = NodeRole::tool;
};

// hub -> node. accepted is false while no slot is free: another live haptics node holds it, or all are taken.
struct Welcome {
  bool accepted = false;
  double servo_rate_hz = 0.0;
};

// node -> hub or hub -> node: leaving on purpose.
struct Bye {};

// hub -> haptics, once a servo cycle.
struct DeviceState {
  std::uint64_t sample = 0;         // counts servo cycles
  std::int64_t sample_time_ns = 0;  // hub's clock, when the device was read
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;
  bool is_resumed = false;   // p_WP is valid: from a join, or from the end of the hub's own force, until the first reply
  Vec3 p_WP = Vec3::Zero();  // where haptics resumes: the proxy in contact, or after the hub's own force also without contact
  // While the hub computes the force of a scene that moves, from its parts: the scene time of this sample. Below 0: haptics determines it.
  std::int64_t scene_time_ns = -1;
};

// What a rigid tool does to an object that programs move. Frame W.
struct ObjectPush {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();  // about the grip point of the tool as it is drawn
  friend bool operator==(const ObjectPush&, const ObjectPush&) = default;
};

// haptics -> hub, one for every DeviceState, at once.
struct ForceCommand {
  std::uint64_t echo_sample = 0;         // the sample of the DeviceState that it replies to
  std::int64_t echo_sample_time_ns = 0;  // its time, unchanged: the round trip is measured on the hub's clock alone
  Vec3 force_n = Vec3::Zero();
  Vec3 visual_offset_m = Vec3::Zero();
  bool contact = false;
  std::uint32_t compute_ns = 0;       // time spent between receiving and sending, haptics' clock
  std::uint32_t skipped_samples = 0;  // states superseded before a reply, since the last command
  std::uint32_t view_revision = 0;    // revision of the newest ViewTransform applied
  std::uint32_t method_serial = 0;    // of the method that computed this force, as in HapticsSetup
  std::uint64_t replied_before = 0;   // bit i: sample echo_sample - 1 - i got a reply as well, so that a lost reply is noticed
  std::uint32_t material_serial = 0;  // of the materials that this force was computed with, as in MaterialState
  std::int32_t object = -1;           // index of the touched object in the scene; -1: none, or unknown
  // Only with a rigid tool; with a probe both are zero:
  Vec3 torque_nm = Vec3::Zero();    // about the device point
  Vec3 visual_turn = Vec3::Zero();  // rotation vector from the stylus to the tool as it is drawn, rad
  // The time of KeyframeMotion and CommandedMotion, which determines where moving objects were. 0: their beginning, or nothing moves.
  std::int64_t scene_time_ns = 0;
  std::uint32_t move_serial = 0;   // of the newest ObjectMove that this force was computed with
  std::uint32_t carve_serial = 0;  // of the newest entry of Carves before this step
  std::uint32_t shape_serial = 0;  // of the newest ShapeStart that this force was computed with
  // The push on `object`. None: the stylus holds no rigid tool, or programs move nothing; so a push does not mean contact.
  std::optional<ObjectPush> push = {};
  // Pairs of triangles of a rigid tool in contact (HP memo, section 5); none: no tool can be held.
  std::optional<std::uint32_t> haptons = {};
  // Proxy minus device point, in a scene with layers, where a needle is drawn elsewhere. None: the same as visual_offset_m. A value does
  // not mean contact.
  std::optional<Vec3> held_offset_m = {};

  const Vec3& held_offset() const noexcept { return held_offset_m ? *held_offset_m : visual_offset_m; }
};

// ForceCommand::replied_before of the first reply in a session that continues an earlier one: which samples got a reply is not known.
constexpr std::uint64_t kUnknownBefore = ~std::uint64_t{0};

// vision -> hub -> haptics and the other vision nodes, when the knob box (dials that turn the static scene) was used: the HP memo's 12
// floats.
struct ViewTransform {
  std::uint32_t revision = 0;
  std::array<float, 12> X_WS = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // row-major 3x4, [R|t]
};

// hub -> vision: the ViewTransform of that revision was not a rigid pose (core/math/rigid_pose.h). The view stays as it was.
struct ViewRejected {
  std::uint32_t revision = 0;
};

// Why there is no force, or not the right one; if there are several causes, the one to fix first.
enum class ProbeStatus : std::uint8_t {
  ok = 0,
  no_haptics = 1,     // no haptics node replies
  fault_latched = 2,  // no force until a person resets it
  device_away = 3,    // unplugged or not responding
  calibrating = 4,    // the device's position is not valid yet
  out_of_reach = 5,   // no part of the scene lies in the device's workspace
  too_small = 6,      // the scene is tiny in that workspace: probably a wrong unit
  hand_inside = 7,    // the hand has been inside a body since haptics began: the body is felt from inside, or not at all
};

// hub -> every vision node. Pose, contact and visual offset belong to one sample: the newest with a reply, or without replies the
// newest of all (offset zero then). Force, buttons and statistics are the newest.
struct ProbeState {
  std::uint64_t sample = 0;
  std::int64_t sample_time_ns = 0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  Vec3 visual_offset_m = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  bool contact = false;
  std::uint32_t buttons = 0;
  float servo_rate_hz = 0.0F;  // measured, for the HUD
  float round_trip_p50_us = 0.0F;
  float round_trip_p99_us = 0.0F;
  // Revision of the ViewTransform that the newest force was computed with, or, without a haptics node, that the hub keeps for the next one.
  std::uint32_t view_revision = 0;
  ProbeStatus status = ProbeStatus::ok;
  // What the device has given the hand beyond what it took, in per cent of the energy budget; at 100 no force is left.
  std::uint32_t energy_percent = 0;
  // Of the sample with the pose above, as in ForceCommand: object, visual_turn, push, haptons.
  std::int32_t object = -1;
  Vec3 torque_nm = Vec3::Zero();  // the newest, of a rigid tool
  Vec3 visual_turn = Vec3::Zero();
  float force_limit_n = 0.0F;      // the largest force that the device may get; 0: unknown
  std::int64_t scene_time_ns = 0;  // of the newest sample with a reply, as in ForceCommand
  std::optional<ObjectPush> push = {};
  std::optional<std::uint32_t> haptons = {};
};

// vision -> hub, after the first frame that shows a state was drawn, or left out because it would look the same: names the sample of the
// state. It requests the next state, and is sent again, as `unchanged`, if none comes.
struct FrameAck {
  std::uint64_t echo_sample = 0;
  std::int64_t echo_sample_time_ns = 0;
  float frame_rate_hz = 0.0F;
  std::uint32_t held_ns = 0;  // from receiving the state to this message, vision's clock; 0: unknown
  std::uint32_t rest_ns = 0;  // from this message until vision can draw again
  bool unchanged = false;     // no frame to measure: none was drawn, as it would look the same, or the state was acknowledged before
  bool every_sample = false;  // no frame was drawn: the sender passes states on, and wants those in which nothing has changed too
};

// vision -> hub: where the mouse moves the hand of the simulated device.
struct HandTarget {
  bool active = false;  // false: the hand returns to its script
  Vec3 p_WH = Vec3::Zero();
  std::uint32_t buttons = 0;     // of the stylus, held down while active
  Vec3 turn_rad = Vec3::Zero();  // yaw, pitch, roll of the stylus (Device::turn_hand)
};

constexpr double kMinServoRateHz = 250.0;
constexpr double kMaxServoRateHz = 10'000.0;

// tool -> hub (and on to haptics): changes a running system. A zero or empty field changes nothing.
struct Settings {
  double servo_rate_hz = 0.0;        // kMinServoRateHz .. kMaxServoRateHz
  std::array<char, 16> method = {};  // NUL-padded name of a force method
  bool report_now = false;           // write the latency report
  bool reset_faults = false;  // a person confirms that the cause of the latched fault is fixed; only from a tool with an operator's key
  std::uint32_t method_request = 0;  // identifies the reply to `method` in HapticsSetup; 0: no reply is awaited
};

// haptics -> hub -> every tool and vision node, when it has changed and once a second: what the forces are computed with, so that a
// recording can be replayed, and the result of the last method request.
struct HapticsSetup {
  using Text = std::array<char, 256>;  // NUL-padded, printable

  std::uint32_t method_serial = 0;  // counts changes of the method while running
  std::uint32_t view_revision = 0;
  std::array<float, 12> X_WS = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::uint64_t scene_hash = 0;  // 0: not known yet, for some milliseconds after an object was put down
  Text scene = {};               // the file's path
  Text build = {};
  Text method = {};                   // "name=proxy probe_radius_m=0 ..."
  std::uint32_t method_request = 0;   // of the Settings that was replied to last; 0: none
  Text rejection = {};                // why that method is not used; empty: it is in use
  std::uint32_t scene_loading = 0;    // unit, sealing and fit of the scene (scene/scene_loading.h); 0: unknown
  std::uint32_t material_serial = 0;  // as in MaterialState, when this method came into use
};

// Some numbers of a material; those that are not given stay as they are.
struct MaterialChange {
  static constexpr std::uint32_t kStiffness = 1;
  static constexpr std::uint32_t kDamping = 2;
  static constexpr std::uint32_t kFrictionStatic = 4;
  static constexpr std::uint32_t kFrictionDynamic = 8;
  static constexpr std::uint32_t kAll = 15;

  std::uint32_t fields = 0;  // which numbers it has: bits of the above
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// tool -> hub -> haptics: changes a material, also of an object that is touched. The haptics node checks the values: it has the scene.
struct MaterialRequest {
  std::uint32_t request = 0;       // identifies the reply in MaterialState; never 0
  HapticsSetup::Text object = {};  // name; empty: all objects
  MaterialChange change;
};

// haptics -> hub -> every tool and vision node, when it has changed and once a second from the first request on: the differences between
// the materials in use and those of the scene file, so that a recording can be replayed, and the result of the last request.
struct MaterialState {
  static constexpr std::size_t kMaxObjects = 20;
  struct Object {
    std::int32_t object = -1;  // index in the scene, from 0; -1: all, before the others
    MaterialChange change;
  };

  std::uint32_t serial = 0;           // counts changes while running
  std::uint32_t request = 0;          // the request that was replied to last; 0: none
  HapticsSetup::Text rejection = {};  // why it changed nothing; empty: it is in use
  std::uint32_t object_count = 0;
  std::array<Object, kMaxObjects> objects = {};
};

// haptics -> hub -> every vision node, vision -> hub -> haptics, when a session begins and once a second: identifies a node's scene, so
// that two nodes notice if their scenes or tools differ. From haptics also points of its surface, to which a simulated hand goes.
struct SceneFacts {
  static constexpr std::size_t kMaxPoints = 16;  // a choice: a hand finds a scene by a few of them
  static constexpr std::uint64_t kNoTool = 1;    // for tool_hash
  // Share of the workspace's longest side, 5 mm for a PHANToM. A smaller scene is a speck in the workspace: the hand cannot find it.
  static constexpr double kSpeckShare = 0.02;
  using Point = std::array<float, 3>;  // frame S, m

  std::uint64_t given_hash = 0;  // of the meshes as the files have them, and their poses (Scene::given_hash)
  Point lowest_m = {};           // corners of its box
  Point highest_m = {};
  std::uint32_t point_count = 0;
  std::array<Point, kMaxPoints> points_m = {};  // spread over its surface
  float preparing_s = 0.0F;                     // above 0: haptics has been preparing its method for this long, and there is no force yet
  bool is_hand_inside = false;                  // inside a body since haptics began: that gives no force, or holds the hand inside
  std::uint64_t tool_hash = 0;                  // SceneTool::given_hash; kNoTool: the stylus is a probe; 0: not known
};

// tool -> hub: requests a part of the hub's report.
enum class ReportDocument : std::uint8_t { json = 0, csv = 1 };
struct ReportRequest {
  ReportDocument document = ReportDocument::json;
  std::uint32_t revision = 0;  // 0: a new report, its first part
  std::uint32_t part = 0;
};

// hub -> the requesting tool.
struct ReportPart {
  ReportDocument document = ReportDocument::json;
  std::uint32_t revision = 0;  // counts the hub's reports, from 1
  std::uint32_t part = 0;
  std::uint32_t parts = 0;  // of the whole document
  std::uint16_t size = 0;   // bytes of text that are used
  std::array<char, 896> text = {};
};

// hub -> haptics, once a second, while haptics computes the force: facts about the loop that the scene's stiffness has to suit.
struct LoopFacts {
  std::array<char, 16> device = {};  // NUL-padded name of the kind of device (Device::name)
  double servo_rate_hz = 0.0;
  float round_trip_s = 0.0F;   // from the sample to its force, p99 since the start
  float max_torque_nm = 0.0F;  // of the device; 0: no motor turns the stylus
};

// haptics -> hub -> every vision node and tool, when it has changed and once a second: the pose of an object that the stylus has picked up
// (docs/tool.md). A point v of the object as the scene file places it is at p_m + q v: in frame T of the stylus as it is drawn while the
// object is held, in frame S otherwise. vision -> hub -> haptics: a request to move it to this pose; serial: of its present pose.
struct ObjectPose {
  std::uint32_t serial = 0;  // counts the changes of all objects, from 1
  std::int32_t object = 0;   // index in the scene
  bool is_held = false;
  Vec3 p_m = Vec3::Zero();
  Quat q = Quat::Identity();
};

// tool, vision or haptics -> hub: something happened, at the newest sample that the hub has. It is recorded (io_node --record).
struct Marker {
  std::uint32_t request = 0;                              // identifies the reply, never 0; the same number again: a repetition
  std::array<char, MarkerText::kMaxBytes + 1> text = {};  // NUL-padded, MarkerText::is_valid
};

// hub -> the sender of a Marker.
enum class MarkerStatus : std::uint8_t {
  recorded = 0,
  no_recording = 1,  // the hub was started without --record
  too_many = 2,      // too many markers of this node, see MarkerLog
  no_room = 3,       // the recording's buffer was full
};
struct MarkerReply {
  std::uint32_t request = 0;
  std::uint64_t sample = 0;  // the sample that the marker belongs to
  MarkerStatus status = MarkerStatus::recorded;
};

// tool or vision -> hub -> haptics: moves an object that programs may move (docs/scene-files.md). Pose as position_m and rotation of the
// scene file; what is not given stays as it is when the move begins.
struct MoveRequest {
  static constexpr double kMaxSeconds = 86'400.0;  // a day

  std::uint32_t request = 0;       // identifies the reply, never 0; the same number again: a repetition
  HapticsSetup::Text object = {};  // name; empty: the object is given by `number`
  std::int32_t number = 0;         // index in the scene, from 0
  std::optional<Vec3> p_m = {};    // at least one of p_m and q is given
  std::optional<Quat> q = {};
  std::optional<double> over_s = {};  // above 0, at most kMaxSeconds; none: the least time allowed
};

// haptics -> hub -> the sender of a MoveRequest.
struct MoveReply {
  std::uint32_t request = 0;
  HapticsSetup::Text rejection = {};  // why the object does not move; empty: it does
  std::int32_t object = 0;            // index in the scene
  double over_s = 0.0;                // duration; more than requested if slowed to the largest speed of a surface
  std::uint32_t serial = 0;           // of its ObjectMove
};

// haptics -> hub -> every vision node, when a program moved an object, and once a second some of all moves in turn: a CommandedMove.
struct ObjectMove {
  std::uint32_t source = 0;   // number of the haptics process, random, never 0
  std::uint32_t serial = 0;   // counts the moves of all objects, from 1; 0: not moved yet
  std::int32_t object = 0;    // index in the scene
  std::int64_t start_ns = 0;  // scene time
  std::int64_t end_ns = 0;
  Vec3 from_p_m = Vec3::Zero();  // position of the pivot, frame S
  Quat from_q = Quat::Identity();
  Vec3 to_p_m = Vec3::Zero();
  Quat to_q = Quat::Identity();
  HapticsSetup::Text name = {};  // of the object in the scene file
};

// haptics -> hub -> every vision node, when the stylus has removed material, and again on request: what was done to the bodies, in entries
// of consecutive serials, each like a MadeCarve (core/sculpt/carve_list.h). Frame: that of the object as the scene file places it. The
// numbers are those that forces and pictures are computed with.
struct Carves {
  static constexpr std::size_t kMax = 32;
  static constexpr float kMaxRadiusM = 1000.0F;  // as scene files allow
  static constexpr float kMaxLengthM = 1000.0F;
  using Point = std::array<float, 3>;  // frame S, m
  struct One {
    std::int32_t object = 0;  // index in the scene
    Point from_m = {};
    Point to_m = {};
    float radius_m = 0.0F;
    bool begins = false;  // the first carve of a press of the button
    // For an undo, whose object is -1: first and last serial of the carves that no longer count, both below its own. 0: this is a carve.
    std::uint32_t undone_first = 0;
    std::uint32_t undone_last = 0;

    bool is_undo() const { return undone_first != 0; }
  };

  std::uint32_t source = 0;  // number of the haptics process, random, never 0: in another process the objects are whole again
  std::uint32_t newest = 0;  // newest serial; serials count the carves of all objects and their undos, from 1; 0: none yet
  std::uint32_t first = 0;   // serial of the first entry here; 0: no entry
  std::uint32_t count = 0;
  std::array<One, kMax> carves = {};
};

// vision -> hub -> haptics, while entries are missing: requests those after `complete` again.
struct CarveStatus {
  std::uint32_t source = 0;    // as in Carves
  std::uint32_t complete = 0;  // all up to this serial have been received
};

// vision -> hub -> haptics: the carves of one press of the button are to be undone. Repeated until their undo is among the Carves.
struct CarveUndo {
  std::uint32_t source = 0;  // as in Carves
  std::uint32_t serial = 0;  // of any carve of that press
};

using Message = std::variant<Hello, Welcome, Bye, DeviceState, ForceCommand, ViewTransform, ProbeState, FrameAck, HandTarget, Settings,
                             HapticsSetup, ReportRequest, ReportPart, SceneFacts, ViewRejected, PatchBegin, PatchCell, PatchTile,
                             PatchStatus, LoopFacts, MaterialRequest, MaterialState, ObjectPose, Marker, MarkerReply, MoveRequest,
                             MoveReply, ObjectMove, Carves, CarveStatus, PatchBody, PatchMaterial, CarveUndo, ShapeRequest, ShapeReply,
                             ObjectShape, ShapeStart, ShapeStatus, PatchDeformation, PatchDisplacements, PatchStream, PatchEffects>;

// Whether a message is a part of the scene. RT: yes.
inline bool is_scene_part(const Message& message) noexcept {
  return std::visit([]<class Kind>(const Kind&) { return kIsScenePart<Kind>; }, message);
}

// The header of every message.
struct Header {
  std::uint64_t session = 0;      // chosen by the hub at start; 0 from a node that has not been welcomed yet
  std::uint64_t sender = 0;       // random per process start: distinguishes a restart from reordering
  std::uint64_t sequence = 0;     // counts this sender's datagrams to this receiver, from 1
  std::int64_t send_time_ns = 0;  // sender's CLOCK_MONOTONIC
};

struct Datagram {
  Header header;
  Message message;
};

}  // namespace hapton
