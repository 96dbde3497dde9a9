#pragma once

#include <atomic>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "core/base/mailbox.h"
#include "devices/device.h"
#include "runtime/byte_ring.h"

namespace hapton::vrpn {

// The device at one servo cycle.
struct FeedSample {
  DeviceSample device;
  Wrench wrench;  // on the motors until this cycle, as written in the cycle before
  DeviceStatus status = DeviceStatus::ready;
  double motor_temperature = -1.0;  // as in DeviceCondition
};

// The proxy of the newest sample that has a force. Frame W, metres.
struct FeedProxy {
  Vec3 p_WP = Vec3::Zero();
  Quat q_WP = Quat::Identity();
  bool is_contact = false;
};

// Passes every sample of the device, and the newest proxy, to an observer in another thread. A slow observer loses samples; the real-time
// threads never wait. RT: push, show_proxy and is_wanted yes, wait-free; the others no. Threads: one calls push, one show_proxy, and one
// take, take_proxy and set_wanted; is_wanted any.
class Feed {
 public:
  Feed() : ring_(kBytes) {}

  void push(const FeedSample& sample) noexcept {
    if (is_wanted_.load(std::memory_order_relaxed)) ring_.push(std::as_bytes(std::span(&sample, 1)), {});
  }

  // Replaces the newest proxy. RT: yes, wait-free.
  void show_proxy(const FeedProxy& proxy) noexcept {
    if (is_wanted_.load(std::memory_order_relaxed)) proxies_.publish(proxy);
  }
  // False: there is no new proxy since the last call, and `proxy` is unchanged.
  bool take_proxy(FeedProxy& proxy) noexcept {
    if (!proxies_.take()) return false;
    proxy = proxies_.value();
    return true;
  }

  // Whether an observer is connected; while none is, samples and proxies are dropped.
  bool is_wanted() const noexcept { return is_wanted_.load(std::memory_order_relaxed); }
  void set_wanted(bool is_wanted) noexcept { is_wanted_.store(is_wanted, std::memory_order_relaxed); }

  // Hands every sample since the last call to visit(const FeedSample&), oldest first.
  template <class Visit>
  void take(Visit&& visit) {
    ring_.drain([&](std::span<const std::byte> bytes) {
      FeedSample sample;
      std::memcpy(static_cast<void*>(&sample), bytes.data(), sizeof sample);
      visit(sample);
    });
  }

 private:
  static constexpr std::size_t kBytes = 1 << 16;  // about 400 samples; the observer takes them every few milliseconds

  ByteRing ring_;
  Mailbox<FeedProxy> proxies_;
  std::atomic<bool> is_wanted_{false};
};

// Wraps a device: passes each sample, with the state of the device, to a feed as well. RT and threads: those of the wrapped device.
class WatchedDevice final : public Device {
 public:
  // Pre: the feed outlives this.
  WatchedDevice(std::unique_ptr<Device> device, Feed& feed) : device_(std::move(device)), feed_(feed) {}

  std::string_view name() const noexcept override { return device_->name(); }
  const DeviceLimits& limits() const noexcept override { return device_->limits(); }
  DeviceSample read(std::int64_t now_ns) noexcept override {
    const DeviceSample sample = device_->read(now_ns);
    feed_.push(
        {sample, is_cut_.load(std::memory_order_relaxed) ? Wrench{} : wrench_, device_->status(), device_->condition().motor_temperature});
    return sample;
  }
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override {
    wrench_ = wrench;
    device_->write(wrench, now_ns);
  }
  bool cut() noexcept override {
    const bool is_off = device_->cut();
    if (is_off) is_cut_.store(true, std::memory_order_relaxed);
    return is_off;
  }
  void restore() noexcept override {
    is_cut_.store(false, std::memory_order_relaxed);
    device_->restore();
  }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { device_->use_heartbeat_page(page); }
  DeviceStatus status() const noexcept override { return device_->status(); }
  DeviceCondition condition() const noexcept override { return device_->condition(); }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override { return device_->set_hand_target(p_WH); }
  bool press_hand_buttons(std::uint32_t buttons) noexcept override { return device_->press_hand_buttons(buttons); }
  bool turn_hand(const Vec3& turn_rad) noexcept override { return device_->turn_hand(turn_rad); }
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override { return device_->aim_hand(p_WA); }

 private:
  std::unique_ptr<Device> device_;
  Feed& feed_;
  Wrench wrench_;
  std::atomic<bool> is_cut_{false};
};

}  // namespace hapton::vrpn
