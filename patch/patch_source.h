#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "link/messages.h"
#include "patch/effect_parts.h"
#include "patch/tile_partition.h"

namespace hapton {

// Position and velocity of the hand, in frame S or that of a body.
struct HandMotion {
  static constexpr double kMeanS = 0.1;  // time constant of the mean of the velocity

  Vec3 p_SD = Vec3::Zero();
  Vec3 v_SD = Vec3::Zero();  // m/s

  // Takes the position in the next sample, dt_s after the last one. The velocity stays if dt_s is 0 or less (the first sample), or 1 s or
  // more. RT: yes.
  void follow(const Vec3& p, double dt_s) noexcept;
};

// Decides which part of a scene goes to the hub next, within a bandwidth: of the parts that the hub does not have, the one nearest to the
// hand and to where it is moving. A part is sent again if the hub's status shows that it was lost, or does not confirm it for too long.
//
// If the scene moves, its bodies are announced first. The parts of a body are in its frame, so they stay valid while it moves; how near
// they are to the hand follows from where the hand is in that frame. The caller sends the moves of objects that programs move as soon as
// they are decided (note_move); this class sends only those that the caller has not, and again those that the hub does not confirm.
//
// Units: SI, ns of one clock. Time is a parameter. RT: no. Threads: one.
class PatchSource {
 public:
  struct Options {
    double bits_per_s = 1e6;      // bandwidth, of IP packets
    double least_reach_m = 0.03;  // parts this near to the hand are sent, and those that a fast hand may come near to meanwhile
    double fastest_m_per_s = 0.3;
  };
  struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t repeated = 0;        // ... of them, sent before
    std::uint64_t held = 0;            // parts that the hub has
    std::uint64_t bytes = 0;           // of IP packets, estimated
    std::uint64_t moves_repeated = 0;  // moves that were sent before, since they were last due anew
  };

  // epoch: for each scene and start one more than the last, never 0.
  PatchSource(TiledScene scene, double probe_radius_m, std::uint64_t scene_hash, std::uint32_t epoch, const Options& options);

  // To call before the first take(). request: the PatchStatus::request that this epoch replies to. method_serial: as in PatchBegin.
  void reply_to(std::uint32_t request, std::uint32_t method_serial) noexcept {
    begin_.request = request;
    begin_.method_serial = method_serial;
  }

  void accept(const PatchStatus& status) noexcept;
  // Takes the position of the hand, in the frame of a body.
  void aim(const HandMotion& hand, std::size_t body = 0) noexcept {
    if (body < hands_.size()) hands_[body] = hand;
  }
  // Takes the newest move of an object, which was sent at sent_ns; below 0: it is not sent yet.
  void note_move(const ObjectMove& move, std::int64_t sent_ns) noexcept;
  // Takes the newest shape of an object that programs deform (ShapeStart::serial).
  void note_shape(std::int32_t object, std::uint32_t serial);
  // Takes the materials that all objects of the scene have from now on. RT: no.
  void set_materials(const std::vector<Material>& materials);

  // The next part to send; none when the hub has all that is in reach, all is on its way, or the bandwidth is used up.
  std::optional<Message> take(std::int64_t now_ns);

  const Counts& counts() const noexcept { return counts_; }
  const TiledScene& scene() const noexcept { return scene_; }

 private:
  static constexpr std::size_t kSerials = 4096;  // serials remembered: eight times PatchStatus::kSerials
  static constexpr std::size_t kMaxPlanned = 64;

  enum class State : std::uint8_t { missing, sent, held };
  struct Item {
    State state = State::missing;
    std::uint32_t serial = 0;        // of the last time it was sent; held: the one that was confirmed
    std::uint32_t first_serial = 0;  // of the first time its present content was sent; 0: not sent yet
    std::int64_t sent_ns = 0;
  };

  // A PatchBody message: some keyframes of the body, or none.
  struct BodyPart {
    std::uint32_t body = 0;
    std::uint32_t first_key = 0;
  };
  // A PatchDeformation message: some weights of a body that deforms.
  struct WeightPart {
    std::uint32_t body = 0;
    std::uint32_t first_key = 0;
  };
  struct MoveItem {
    ObjectMove move;
    bool is_held = false;
    std::int64_t sent_ns = -1;
    int repeats = 0;
  };
  struct TunedObject {
    std::uint32_t object = 0;
    Material material;
  };

  void begin_again() noexcept;
  std::size_t item_of_effects(std::size_t part) const noexcept { return 1 + body_parts_.size() + part; }
  std::size_t item_of_cell(std::size_t cell) const noexcept { return item_of_effects(count_effect_parts(scene_.effects.size())) + cell; }
  std::size_t item_of_tile(std::size_t tile) const noexcept { return item_of_cell(scene_.cells.size()) + tile; }
  std::size_t item_of_weights(std::size_t part) const noexcept { return item_of_tile(scene_.tiles.size()) + part; }
  std::size_t item_of_displaced(std::size_t at) const noexcept { return item_of_weights(weight_parts_.size()) + at; }
  std::size_t item_of_stream(std::size_t at) const noexcept { return item_of_displaced(scene_.displaced.size()) + at; }
  std::size_t item_of_material(std::size_t tuned) const noexcept { return item_of_stream(scene_.streams.size()) + tuned; }
  bool is_due(const Item& item, std::int64_t now_ns) const noexcept;
  std::int64_t resend_after_ns() const noexcept;
  void plan(std::int64_t now_ns);
  void plan_bodies(std::int64_t now_ns);
  void plan_tiles(std::int64_t now_ns);
  template <class Add>
  void plan_deforming(std::uint32_t body, Add&& add);
  double distance_of(const Box& bounds, std::uint32_t body) const noexcept;
  double reach_of(std::uint32_t body) const noexcept;
  Message make_message(std::size_t item);
  PatchBody make_body(const BodyPart& part) const;
  PatchDeformation make_deformation(const WeightPart& part) const;
  MoveItem* find_due_move(std::int64_t now_ns) noexcept;
  std::optional<Message> take_move(MoveItem& item, std::int64_t now_ns);
  bool spend_credit(const Message& message, std::int64_t now_ns) noexcept;

  TiledScene scene_;
  PatchBegin begin_;
  Options options_;
  std::vector<HandMotion> hands_;           // by body
  std::vector<BodyPart> body_parts_;        // none where nothing moves
  std::vector<WeightPart> weight_parts_;    // by body
  std::vector<MoveItem> moves_;             // by object
  std::vector<TunedObject> tuned_objects_;  // objects that got another material than that of their tiles
  std::vector<Material> tile_materials_;    // materials of the tiles, by object
  std::vector<Item> items_;                 // PatchBegin, bodies, effects, cells, tiles, weights, displacements, streams, materials
  std::vector<std::uint32_t> in_flight_;    // by serial modulo kSerials: the item
  std::uint32_t serial_ = 0;
  double round_trip_s_ = 0.0;
  double credit_bytes_ = 0.0;
  std::int64_t credited_ns_ = 0;
  std::vector<std::size_t> planned_;  // items in reverse order: the last one is sent first
  std::int64_t planned_ns_ = 0;
  std::vector<std::array<Vec3, 3>> hand_ahead_;  // by body, in steps of the grid: where the hand is and may come to
  Counts counts_;
};

// Whether each body that deforms can be felt from its parts: its surface is walkable on their grid. RT: no.
bool can_feel_what_deforms(const TiledScene& scene, double probe_radius_m);

}  // namespace hapton
