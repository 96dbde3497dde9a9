#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/math/types.h"
#include "link/messages.h"

namespace hapton {

// Three dials that turn the static scene about the world's axes through the workspace centre (memo 4.1, 4.2.1): first x, then y,
// then z. Units: degrees. RT: no.
struct Dials {
  Vec3 degrees = Vec3::Zero();

  // Turns one dial (0, 1, 2 for x, y, z), keeping it within (-180, 180]. A turn that is not finite is ignored.
  void turn(int axis, double by_degrees);

  // The pose of the static scene: R_z R_y R_x about p_WC, applied to home_WS, the pose of the scene at dials zero.
  Pose compute_pose(const Vec3& p_WC, const Pose& home_WS = Pose::Identity()) const;

  friend bool operator==(const Dials&, const Dials&) = default;
};

// The dials with which a scene whose home is the identity has that pose, to a float's precision; none: no dials give it.
std::optional<Dials> find_dials(const Pose& X_WS, const Vec3& p_WC);

// A pose as the memo's twelve floats: the rows of [R|t].
std::array<float, 12> to_twelve_floats(const Pose& X_WS);
Pose from_twelve_floats(const std::array<float, 12>& m);

// Decides when the view transform is sent to the hub: when a dial was turned, and again while ProbeState shows that it has not arrived (it
// was lost, or the hub was restarted). Times: any monotonic clock, ns. Threads: one. RT: no.
class ViewTransformSender {
 public:
  // Sets the newest pose. A pose with the same twelve floats as the last one is not sent.
  void set(const Pose& X_WS);

  // The revision that the hub last reported as in use (ProbeState::view_revision). If the hub's first report is not below this node's
  // revision, it comes from an earlier vision node: this node's revisions then continue from it.
  void confirm(std::uint32_t hub_revision);

  // Takes over the view that the hub has from another vision node, or had before this one joined: it is then the newest, and is not sent.
  // False: it is the newest already, or this node has a newer one, which stays (unless any_revision: then the hub's view is taken over).
  bool adopt(const ViewTransform& view, bool any_revision = false);
  // The hub has a view with that revision, which is not taken over: the next pose gets a larger revision.
  void count_from(std::uint32_t revision);

  // The hub rejected the transform of that revision: it is not sent again, and the log says so once.
  void reject(std::uint32_t revision);

  // The hub has accepted this node, for the first time or again: the pose must be sent.
  void rejoin();

  // The message to send now, if one is due; it then counts as sent.
  std::optional<ViewTransform> take_due(std::int64_t now_ns);

  std::uint32_t revision() const { return newest_.revision; }
  // The pose with that revision, as twelve floats have it; none: it is more than kHistory revisions old, or was neither set nor adopted.
  std::optional<Pose> find_pose(std::uint32_t revision) const;
  std::uint64_t sent() const { return sent_count_; }

  static constexpr std::size_t kHistory = 64;  // poses that are kept: of about a second, at one a frame; the hub confirms one far sooner

 private:
  void note_newest() { history_[newest_.revision % kHistory] = newest_; }

  ViewTransform newest_;
  std::array<ViewTransform, kHistory> history_ = {};  // at index revision % kHistory
  std::uint32_t confirmed_revision_ = 0;
  std::uint32_t rejected_revision_ = 0;  // 0: none
  bool has_hub_reported_ = false;
  bool is_adopted_ = false;  // the newest was taken over from the hub
  bool is_due_ = false;
  std::int64_t sent_ns_ = 0;
  std::uint64_t sent_count_ = 0;
};

}  // namespace hapton
