#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/mailbox.h"
#include "io_node/local_patch.h"
#include "io_node/work_share.h"
#include "link/messages.h"
#include "patch/patch_maker.h"
#include "patch/patch_store.h"
#include "runtime/handoff_ring.h"

namespace hapton {

// What the patch thread has done, for reports.
struct PatchThreadCounts {
  PatchStore::Counts store;
  std::uint64_t built = 0;
  std::uint64_t triangles = 0;  // of the newest patch
  double radius_m = 0.0;        // of the newest patch; infinity: the whole scene
  double build_ms = 0.0;        // of the newest patch
  std::uint64_t stages = 0;     // motions to shapes that programs gave
  double stages_s = 0.0;        // time spent on making stages, those that failed included
};

// The thread that stores the parts of the scene that have come and runs a PatchMaker for each body, which makes patches of them around the
// hand.
//
// The haptics node decides how many shapes come, and which patches fail. So making stages takes at most kStageShare of the time, and
// attempts that give no patch of a body at most kFailureShare for each body, beyond a burst; work beyond that waits. An attempt that finds
// no patch due counts as well: it takes microseconds, but the parts decide how many there are.
// RT: push, push_shape, take_shape_request, clear, take_status, status and counts yes; construction and destruction set-up only. Threads:
// one, the network side's.
class PatchThread {
 public:
  static constexpr double kStageShare = 0.5;
  static constexpr std::int64_t kStageBurstNs = 1'000'000'000;  // several of the largest stages in a row
  static constexpr double kFailureShare = 0.5 / PatchBody::kMaxBodies;
  static constexpr std::int64_t kFailureBurstNs = 250'000'000;

  // Pre: outlives this.
  explicit PatchThread(LocalPatch& local);
  ~PatchThread();
  PatchThread(const PatchThread&) = delete;
  PatchThread& operator=(const PatchThread&) = delete;

  // Passes on a part that came. A part that finds no room is dropped, and comes again as it is never confirmed.
  void push(const Message& part) noexcept { (void)write(&part, Arrival::newest); }
  // Passes on the shape of an object that programs deform, or its start (PatchStore::accept_shape). If there is no room it is dropped.
  void push_shape(const Message& shape, Arrival arrival) noexcept { (void)write(&shape, arrival); }
  // The next request for parts of a shape that are missing; none: there is none now.
  std::optional<ShapeStatus> take_shape_request() noexcept;
  // Drops everything that came, as it is of no use any more. False: no room, call again.
  bool clear() noexcept;
  // True: there is a new status of what has come since the last clear().
  bool take_status() noexcept { return statuses_.take(); }
  PatchStatus status() const noexcept {
    return statuses_.value().clear_count == requested_clears_ ? statuses_.value().status : PatchStatus();
  }
  const PatchThreadCounts& counts() noexcept {
    counts_.take();
    return counts_.value();
  }

 private:
  // At most 300 kB of datagrams; a whole scene's parts are 0.3 to 1.1 MB (decision 197).
  static constexpr std::size_t kRingSlots = 256;
  struct Slot {
    bool is_clear = false;
    Arrival arrival = Arrival::newest;
    Message part;
  };

  struct Status {
    PatchStatus status;
    std::uint32_t clear_count = 0;  // number of calls of clear() before this status
  };

  bool write(const Message* part, Arrival arrival) noexcept;
  void run();
  bool drain();
  void begin_epoch(bool is_cleared);
  void offer_news();
  bool build_where_due();
  bool is_in_use(std::size_t link) const noexcept;
  void build_if_due(std::size_t link);
  void make_stage_if_due(std::size_t link);
  void note_stage(std::int64_t took_ns, std::uint32_t vertices) noexcept;
  void request_missing_shapes();

  LocalPatch& local_patch_;
  std::array<Slot, kRingSlots> ring_;
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
  std::uint32_t requested_clears_ = 0;
  Mailbox<Status> statuses_;
  Mailbox<PatchThreadCounts> counts_;
  HandoffRing<ShapeStatus, 64> shape_requests_;  // if it is full, the newest shape is requested again later

  // Used by the patch thread alone.
  PatchStore store_;
  std::uint32_t generation_ = 0;
  std::uint32_t done_clears_ = 0;
  std::uint32_t epoch_ = 0;
  std::vector<PatchMaker> makers_;      // by body
  bool are_bodies_offered_ = false;     // the bodies of this epoch
  std::uint32_t material_version_ = 0;  // of the materials that were offered last
  std::vector<ShapeStatus> requests_;
  PatchThreadCounts thread_counts_;
  WorkShare stage_work_{kStageShare, kStageBurstNs};
  std::vector<WorkShare> failed_work_;  // by body
  float shape_s_per_vertex_ = 0.0F;     // as in PatchStatus
  bool has_made_stage_ = false;         // since the last status

  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
