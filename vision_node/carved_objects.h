#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <thread>
#include <vector>

#include "core/sculpt/carve_list.h"
#include "link/known_carves.h"
#include "link/messages.h"
#include "recording/recording_index.h"
#include "scene/scene_file.h"
#include "vision_node/carved_surface.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Draws the objects that the stylus carves with the shapes that they have in the haptics node: from the same field with the same carves. A
// thread of this class applies the carves and computes the surfaces, up to 30 times a second; the window's thread only hands over what is
// finished, and never waits for that. Threads: all calls from the window's. RT: no.
class CarvedObjects {
 public:
  // Starts the thread if the scene has such objects; they are drawn as their meshes until it has made their fields. Pre: both outlive this;
  // the view was opened with the scene's objects.
  CarvedObjects(StereoView& view, const Scene& scene);
  ~CarvedObjects();
  CarvedObjects(const CarvedObjects&) = delete;
  CarvedObjects& operator=(const CarvedObjects&) = delete;

  // Takes a message of the haptics node. arrival: HubClient::last_arrival() of that message.
  void take(const Carves& carves, Arrival arrival);
  // Takes carves from a recording, which knows which entries are new. starts_anew: the objects are whole before these carves.
  void carve(std::span<const NumberedCarve> carves, bool starts_anew);
  // A request to the hub, if carves are missing and it is due; none otherwise.
  std::optional<CarveStatus> take_request(std::int64_t now_ns);

  // The entries that were received of what was done to the bodies.
  const CarveList& list() const { return received_carves_; }
  // Identification of the haptics node, as in Carves; 0: nothing was received yet.
  std::uint32_t source() const { return known_.source(); }
  // Whether all carves were received that the haptics node has announced.
  bool is_complete() const { return known_.source() != 0 && known_.complete() >= known_.newest(); }

  // Hands finished surfaces to the view. True: there were some, so the picture has changed.
  bool show();

  // The point of an object's surface that is closest to p, with the carves that the thread has applied: all but those of about the last
  // 1/30 s. None: the object cannot be carved, its field is not made yet, or nothing is left of it. Waits at most while the thread applies
  // one carve or undo. Frame O, where the scene file places the object. Pre: p is finite.
  std::optional<Vec3> find_closest(std::size_t object, const Vec3& p) const;

  // The material of all objects that can be carved, by object, with exactly the carves that were taken before this call. The thread copies
  // it; the future becomes ready in any case, also when this object is destroyed. Frame O.
  using Fields = std::map<std::size_t, CarvedField>;
  std::future<Fields> request_fields() const;

  // Whether the view has everything that was received.
  bool is_up_to_date() const;

 private:
  struct Order {
    bool starts_anew = false;
    std::vector<MadeCarve> carves;
    std::optional<std::promise<Fields>> wanted;  // gets a copy after these carves; later carves are in the next order
  };
  using Orders = std::vector<Order>;
  struct FinishedSurface {
    std::size_t object = 0;
    std::vector<FlatLevel> levels;
  };

  void add_order(const MadeCarve& made);
  void begin_anew();
  void run();
  void make_surfaces();
  Order& open_order() const;
  std::size_t count_waiting() const;
  bool wait_for_orders(Orders& orders);
  void carry_out(Orders& orders);
  void apply(const Order& order);
  void apply(const MadeCarve& made);
  Fields copy_fields() const;
  void offer_changed();
  void offer(std::size_t object, std::vector<FlatLevel> levels);

  StereoView& view_;
  const Scene& scene_;
  KnownCarves known_;
  CarveList received_carves_;  // what the window's thread has taken
  CarveList applied_carves_;   // what the thread's surfaces have
  bool has_bodies_ = false;
  std::map<std::size_t, CarvedSurface> surfaces_;  // by object; used by the thread, which changes their fields under fields_mutex_
  mutable std::shared_mutex fields_mutex_;

  mutable std::mutex mutex_;
  mutable std::condition_variable orders_changed_;
  mutable Orders orders_;                           // what came since the thread last took them
  bool is_busy_ = false;                            // the thread has work, or is at work
  std::vector<FinishedSurface> finished_surfaces_;  // the newest surfaces, at most one of each object, that show() has not taken yet
  bool is_stopping_ = false;
  std::thread thread_;  // last member, because it uses the others
};

}  // namespace hapton
