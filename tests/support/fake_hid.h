#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "hid/hid_transport.h"

namespace hapton {

// A HID device in this process that behaves like one behind the kernel: it queues 64 reports for the reader, drops new ones when the queue
// is full, and may be unplugged and plugged in again at any time.
class FakeHid {
 public:
  using Bytes = std::vector<std::uint8_t>;
  static constexpr std::size_t kQueueCapacity = 64;

  explicit FakeHid(HidDescription description = {}) : shared_(std::make_shared<Shared>()) { shared_->description = std::move(description); }

  HidOpener opener() const {
    return [shared = shared_]() -> Result<std::unique_ptr<HidTransport>> {
      const std::lock_guard lock(shared->mutex);
      if (!shared->is_plugged) return fail("the fake device is not plugged in");
      shared->reports.clear();
      ++shared->openings;
      return std::make_unique<Transport>(shared, shared->plugging);
    };
  }

  void unplug() {
    change([](Shared& shared) { shared.is_plugged = false; });
  }
  void plug_in() {
    change([](Shared& shared) {
      shared.is_plugged = true;
      ++shared.plugging;
    });
  }
  // False: the queue is full, the report is lost.
  bool send(const Bytes& report) {
    bool is_queued = false;
    change([&](Shared& shared) {
      is_queued = shared.reports.size() < kQueueCapacity;
      if (is_queued) shared.reports.push_back(report);
    });
    return is_queued;
  }
  void set_feature(std::uint8_t id, const Bytes& report) {
    change([&](Shared& shared) { shared.features[id] = report; });
  }
  // While true, writes wait.
  void block_writes(bool blocks) {
    change([&](Shared& shared) { shared.blocks_writes = blocks; });
  }
  // Refuses that many of the next writes. then_hangs: later writes wait until this is called again, even if the device is unplugged.
  void refuse_next(int writes, bool then_hangs = false) {
    change([&](Shared& shared) {
      shared.refusals = writes;
      shared.hangs_after_refusals = then_hangs;
    });
  }
  void refuse_writes(bool refuses) {
    change([&](Shared& shared) { shared.refuses_writes = refuses; });
  }

  std::size_t written() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->written.size();
  }
  std::vector<Bytes> take_written() {
    const std::lock_guard lock(shared_->mutex);
    return std::exchange(shared_->written, {});
  }
  bool has_waiting_writer() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->waiting_writers > 0;
  }
  bool is_drained() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->reports.empty();
  }
  int openings() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->openings;
  }

 private:
  struct Shared {
    mutable std::mutex mutex;
    std::condition_variable changed;
    HidDescription description;
    bool is_plugged = true;
    int plugging = 0;  // how often it was plugged in again: a transport of an earlier plugging stays gone
    int openings = 0;
    bool blocks_writes = false;
    bool refuses_writes = false;
    bool hangs_after_refusals = false;
    int refusals = 0;  // writes still to be refused
    int waiting_writers = 0;
    std::deque<Bytes> reports;
    std::vector<Bytes> written;
    std::map<std::uint8_t, Bytes> features;
  };

  class Transport final : public HidTransport {
   public:
    Transport(std::shared_ptr<Shared> shared, int plugging) : shared_(std::move(shared)), plugging_(plugging) {}

    const HidDescription& description() const noexcept override { return shared_->description; }

    HidRead read(std::span<std::uint8_t> into, int wait_ms) noexcept override {
      std::unique_lock lock(shared_->mutex);
      shared_->changed.wait_for(lock, std::chrono::milliseconds(wait_ms), [&] { return is_gone() || !shared_->reports.empty(); });
      if (is_gone()) return {HidIo::gone, 0};
      if (shared_->reports.empty()) return {};
      const Bytes report = shared_->reports.front();
      shared_->reports.pop_front();
      const std::size_t size = std::min(report.size(), into.size());
      std::copy_n(report.begin(), size, into.begin());
      return {HidIo::done, size};
    }

    bool write(std::span<const std::uint8_t> report) noexcept override {
      std::unique_lock lock(shared_->mutex);
      ++shared_->waiting_writers;
      shared_->changed.wait(lock, [&] { return !hangs() && (is_gone() || !shared_->blocks_writes); });
      --shared_->waiting_writers;
      if (is_gone() || shared_->refuses_writes) return false;
      if (shared_->refusals > 0) {
        --shared_->refusals;
        return false;
      }
      shared_->written.emplace_back(report.begin(), report.end());
      return true;
    }

    Result<std::size_t> get_feature(std::span<std::uint8_t> into) override {
      const std::lock_guard lock(shared_->mutex);
      const auto found = shared_->features.find(into[0]);
      if (is_gone() || found == shared_->features.end()) return fail("no such feature report");
      const std::size_t size = std::min(found->second.size(), into.size());
      std::copy_n(found->second.begin(), size, into.begin());
      return size;
    }

   private:
    bool hangs() const { return shared_->hangs_after_refusals && shared_->refusals == 0; }
    bool is_gone() const { return !shared_->is_plugged || shared_->plugging != plugging_; }

    std::shared_ptr<Shared> shared_;
    int plugging_;
  };

  template <class Change>
  void change(Change&& change) {
    {
      const std::lock_guard lock(shared_->mutex);
      change(*shared_);
    }
    shared_->changed.notify_all();
  }

  std::shared_ptr<Shared> shared_;
};

}  // namespace hapton
