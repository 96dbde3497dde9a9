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

// Draws the objects that the stylus carves as the haptics node has them: from the same field with the same carves. A thread of its own
// applies the carves and computes the surface, up to 30 times a second; the window's thread only hands over what is finished, and never
// waits for it. Threads: all calls from the window's. RT: no.
class CarvedObjects {
 public:
  // Starts the thread if the scene has such objects; until it has made their fields they are drawn as their meshes. Pre: both outlive this;
  // the view was opened with the scene's objects.
  CarvedObjects(StereoView& view, const Scene& scene);
  ~CarvedObjects();
  CarvedObjects(const CarvedObjects&) = delete;
  CarvedObjects& operator=(const CarvedObjects&) = delete;

  // arrival: as HubClient::last_arrival of this message.
  void take(const Carves& carves, Arrival arrival);
  // The same from a recording, which knows which entries are new.
  void carve(std::span<const NumberedCarve> carves, bool starts_anew);
  // For the hub, if carves are missing and a request is due.
  std::optional<CarveStatus> take_request(std::int64_t now_ns);

  // What was done to the bodies, as far as it was received.
  const CarveList& list() const { return list_; }
  // Of the haptics node, as in Carves; 0: nothing was received yet.
  std::uint32_t source() const { return known_.source(); }
  // All that the haptics node has announced was received.
  bool is_complete() const { return known_.source() != 0 && known_.complete() >= known_.newest(); }

  // True if the view has got a surface since the last call: the picture has changed.
  bool show();

  // The point of an object's surface that is closest to p, with the carves that the thread has carried out: all but those of the last 1/30
  // s. None: nobody can carve it, its field is not made yet, or nothing is left of it. Waits for a carve, or an undo, at most. Frame S.
  // Pre: finite.
  std::optional<Vec3> find_closest(std::size_t object, const Vec3& p) const;

  // The material of all objects that can be carved, by object, with all carves that were taken until now, and none that is taken later. The
  // thread copies it; it comes in any case, also at the end of this. Frame S.
  using Fields = std::map<std::size_t, CarvedField>;
  std::future<Fields> request_fields() const;

  // Everything received is drawn.
  bool is_up_to_date() const;

 private:
  struct Order {
    bool starts_anew = false;
    std::vector<MadeCarve> carves;
    std::optional<std::promise<Fields>> wanted;  // a copy, after these carves; what comes later is of the next order
  };
  using Orders = std::vector<Order>;
  struct Made {
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
  CarveList list_;     // the window's
  CarveList applied_;  // the thread's: what its surfaces have
  bool has_any_ = false;
  std::map<std::size_t, CarvedSurface> surfaces_;  // by object; the thread's, which changes their fields under fields_mutex_
  mutable std::shared_mutex fields_mutex_;

  mutable std::mutex mutex_;
  mutable std::condition_variable ordered_;
  mutable Orders orders_;   // what came since the thread took the last ones
  bool is_busy_ = false;    // the thread has something to do, or is doing it
  std::vector<Made> made_;  // the newest of each object, not shown yet
  bool stop_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hapton
