#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "link/hub_connection.h"
#include "link/known_carves.h"
#include "link/known_moves.h"
#include "link/messages.h"
#include "link/move_request.h"
#include "link/others_view.h"
#include "link/settings_request.h"
#include "link/shape_outbox.h"
#include "python/reply_awaiter.h"

namespace hapton::python {

// Sits at a hub as a vision node: a thread keeps the newest probe state and asks for the next. Threads: any.
class LiveClient {
 public:
  // Error, one line: as HubConnection::open, or no hub replies.
  static Result<std::unique_ptr<LiveClient>> open(const std::string& hub, const std::string& key_file);
  ~LiveClient();
  LiveClient(const LiveClient&) = delete;
  LiveClient& operator=(const LiveClient&) = delete;

  // None before the first.
  std::optional<ProbeState> newest();
  bool is_joined() const noexcept { return is_joined_.load(std::memory_order_relaxed); }
  // The pose of the static scene. The hub sends what the forces are computed with back, as ProbeState::view_revision. Error, one line: this
  // client is closed.
  Result<std::uint32_t> turn_scene(const std::array<float, 12>& X_WS);
  // Marks the recording; the number of the sample. Error, one line: nothing is recorded, too many, or no reply. Threads: any.
  Result<std::uint64_t> mark(std::string_view text);
  // Where an object is that programs may move, at a scene time; none given: at that of the newest state. None: there is no state yet, or as
  // KnownMoves::find. Threads: any.
  std::optional<KnownMoves::Placed> find_object(std::int32_t object, std::optional<double> scene_time_s);
  // As KnownMoves::find_named and find_name. Threads: any.
  KnownMoves::Named find_named(std::string_view name);
  std::string find_name(std::int32_t object);
  // Those that programs may move, as far as they have been announced. Threads: any.
  std::vector<std::int32_t> movable_objects();
  // What the stylus has carved, in order, as far as it has come; the newest serial that the haptics node has announced. Threads: any.
  struct CarvesSoFar {
    std::vector<Carves::One> carves = {};
    std::uint32_t newest = 0;
  };
  CarvesSoFar find_carves(std::uint32_t after);
  // Requests that an object moves; the time that the move takes, s. Error, one line: why it does not, or no reply. Threads: any.
  Result<double> move_object(std::string_view object, const MoveTarget& target);
  // Gives an object that programs deform its next shape, as ShapeOutbox::give. Waits: the time that the surface takes to it, s; the shape
  // is sent again until its reply comes. Otherwise 0, at once: of shapes that wait to be sent, the newest is. Error, one line: a shape that
  // cannot be; of one that is waited for, why the object does not take it, or no reply. Threads: any.
  Result<double> set_shape(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s, bool waits);
  // The newest rejection of a shape that was not waited for, once; empty: none since. Threads: any.
  std::string take_shape_rejection();
  // Joins for a moment as a tool, and changes method, materials or rate; what is in use then, in one line. key_file: of a tool, or for all
  // roles; empty: that of this client. Error, one line: as apply_settings. Threads: any.
  Result<std::string> set(const SettingsChange& change, const std::string& key_file);
  void stop();

 private:
  LiveClient(std::unique_ptr<HubConnection> connection, HubConnection::Settings settings);
  void run();
  void take_move(const Message& message, Arrival arrival);
  void request_carves(HubClient& client, std::int64_t now_ns);
  void take_shape_reply(const Message& message);
  void take_carves(const Message& message, Arrival arrival);
  void take_view(const Message& message, Arrival arrival);
  void send_view(std::int64_t now_ns) noexcept;

  HubConnection::Settings settings_;
  std::unique_ptr<HubConnection> connection_;
  std::mutex mutex_;  // of the next seven
  std::string shape_rejection_;
  std::optional<ProbeState> newest_;
  ViewTransform view_ = {};
  OthersView others_view_;
  KnownMoves known_moves_;
  KnownCarves known_carves_;
  std::vector<Carves::One> carves_;  // by serial - 1; valid up to known_carves_.complete()
  std::int64_t next_view_ns_ = 0;
  Markers markers_;
  ReplyAwaiter<MoveRequest, MoveReply> moves_;
  ShapeOutbox shapes_;
  std::atomic<bool> is_joined_{true};
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace hapton::python
