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

// A client that joins a hub as a vision node: a thread keeps the newest probe state and requests the next one. Threads: any.
class LiveClient {
 public:
  // Error, one line: as HubConnection::open, or no hub replies.
  static Result<std::unique_ptr<LiveClient>> open(const std::string& hub, const std::string& key_file);
  ~LiveClient();
  LiveClient(const LiveClient&) = delete;
  LiveClient& operator=(const LiveClient&) = delete;

  // The newest probe state. None before the first one.
  std::optional<ProbeState> newest();
  bool is_joined() const noexcept { return is_joined_.load(std::memory_order_relaxed); }
  // Sets the pose of the static scene and returns its revision; ProbeState::view_revision says which one the forces are computed with.
  // Waits up to about 1 s for the first probe state. Error, one line: this client is closed.
  Result<std::uint32_t> turn_scene(const std::array<float, 12>& X_WS);
  // Marks the recording and returns the number of the sample. Error, one line: as request_mark, or this client is closed. Threads: any.
  Result<std::uint64_t> mark(std::string_view text);
  // Where an object that programs may move is at a scene time, by default that of the newest probe state. None: there is no state yet, or
  // KnownMoves::find gives none. Threads: any.
  std::optional<KnownMoves::Placed> find_object(std::int32_t object, std::optional<double> scene_time_s);
  // The same as KnownMoves::find_named and KnownMoves::find_name. Threads: any.
  KnownMoves::Named find_named(std::string_view name);
  std::string find_name(std::int32_t object);
  // The objects that programs may move, of those announced so far. Threads: any.
  std::vector<std::int32_t> movable_objects();
  // The carves with serials above `after`, in order, up to the first missing one; newest: the newest serial announced. Threads: any.
  struct CarvesSoFar {
    std::vector<Carves::One> carves = {};
    std::uint32_t newest = 0;
  };
  CarvesSoFar find_carves(std::uint32_t after);
  // Moves an object; waits, and returns the time that the move takes, s. Error, one line: why it does not move, or no reply. Threads: any.
  Result<double> move_object(std::string_view object, const MoveTarget& target);
  // Gives an object that programs deform its next shape, as ShapeOutbox::give. waits: sends the shape until its reply comes, and returns
  // the time that the surface takes to it, s. Otherwise returns 0 at once; of shapes that wait, only the newest is sent. Error, one line: a
  // shape that is not allowed; with `waits` also why the object does not take it, or no reply. Threads: any.
  Result<double> set_shape(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s, bool waits);
  // The newest rejection of a shape, also of one that was waited for, since the last call; empty: there was none. Threads: any.
  std::string take_shape_rejection();
  // Joins for a moment as a tool, changes method, materials or rate, and returns what is in use then, in one line. key_file: for the
  // role tool, or for all roles; empty: that of this client. Error, one line: as apply_settings. Threads: any.
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
  std::mutex mutex_;  // for shape_rejection_ to next_view_ns_
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
  std::mutex stop_mutex_;  // of two threads that close this at once, one waits for the other
  std::thread thread_;
};

}  // namespace hapton::python
