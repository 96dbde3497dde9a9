#pragma once

#include <string>
#include <string_view>

#include "link/messages.h"

namespace hapton {

struct HudFacts {
  bool is_connected = false;
  ProbeState state;
  double frame_rate_hz = 0.0;  // 0: too few frames were drawn to know it
  Vec3 dials_degrees = Vec3::Zero();
  std::string_view stereo;
  bool cull = true;              // triangles seen from behind are left out
  bool is_hand_led = false;      // the mouse leads the hand
  double detail_progress = 1.0;  // share of the levels of detail that has been made, 0 to 1
  double preparing_s = 0.0;      // haptics_node has been building its scene for this long; 0: it is not
  bool is_other_scene = false;   // haptics_node has another scene than the one shown
  bool is_other_tool = false;    // haptics_node has another rigid tool than the one drawn
  std::string touched_name;      // name and material of the object touched; empty: none, or not known
  std::string annotations;       // what is drawn and measured, a line of its own; empty: nothing
  std::string held_name;         // name and material of the object that the stylus has picked up; empty: none
  std::string head;              // position of the head; empty: the initial one
  std::string head_notice;       // what is wrong with the head tracker, a line of its own; empty: nothing
  std::string scene_problem;     // why the scene file as last saved is not shown, a line of its own; empty: it is shown
  std::string recording;         // the recording that is shown: name, moment, how it plays; a line of its own. Empty: live
  std::string teaching;          // what a teaching view shows, a line of its own; empty: none
  std::string recent_event;      // what happened just before, in the recording or live (a file was written), a line of its own; empty: none
  double scene_diameter_m = 0.0;  // diameter of the scene
  double scene_distance_m = 0.0;  // from its middle to that of the workspace, with the dials as they are now
};

// What this state means for the user, and what to do; empty for ProbeStatus::ok.
std::string_view describe(ProbeStatus status);

// The few lines in the picture's corner: rates, latency, force. Rounded so that irrelevant noise does not change it.
std::string compose_hud(const HudFacts& facts);

// What is wrong with the scene as a whole, and what to do: for large letters, so that it is seen before anything is looked for. Empty while
// the device can touch what is shown.
std::string compose_notice(const HudFacts& facts);

// The keys and the mouse, for the picture's lower edge and for --help.
std::string_view keys_help();
// The keys and the mouse for a recorded session.
std::string_view recording_keys_help();

}  // namespace hapton
