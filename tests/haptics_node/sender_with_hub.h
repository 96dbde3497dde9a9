#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "haptics_node/patch_sender.h"
#include "patch/patch_store.h"
#include "runtime/clock.h"
#include "tests/support/made_scene.h"

namespace hapton {

inline constexpr std::array<float, 12> kIdentityPose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// A PatchSender, and the side of the hub, which requests the parts of the scene. The default scene is a sheet of 20 x 20 squares (800
// triangles). The probe is a point, the hash of the scene is 7, and at least the parts up to 1 m from the hand are sent. is_offered: the
// method in use can be computed from parts, so the hub gets them.
struct SenderWithHub {
  explicit SenderWithHub(bool is_offered = true, TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20)))
      : sender(std::move(scene), 0.0, 7, is_offered, {.bits_per_s = 1e8, .least_reach_m = 1.0}) {}

  // Sends the status of the hub, which requests the parts, and a sample.
  void request_parts() {
    PatchStatus status = store.status();
    status.is_wanted = true;
    status.request = request;
    status.knows_effects = knows_effects;
    status.newest_move = confirmed_moves.newest();
    status.moves_received = confirmed_moves.received();
    sender.accept(status, clock.now_ns());
    sender.note_hand({.sample = ++sample, .sample_time_ns = clock.now_ns(), .p_WD = p_WD}, X_WS);
  }
  // Receives all parts that are sent within this time.
  void receive_for(std::chrono::milliseconds time) {
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      request_parts();
      for (const Message* part = sender.front(); part != nullptr; part = sender.front()) {
        // All that is sent is a part of the scene or a move of an object that programs move.
        if (!store.accept_part(*part)) moves.push_back(std::get<ObjectMove>(*part));
        ++received_count;
        sender.pop();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  // Until holds(), loses all that the sender sends, and sends no status of the hub. Returns false if it did not hold within 30 s.
  bool lose_until(const auto& holds) {
    for (int n = 0; n < 6000 && !holds(); ++n) {
      for (; sender.front() != nullptr && !holds(); sender.pop()) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return holds();
  }
  std::size_t triangles() const { return store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles; }
  bool receive_until(const auto& holds) {
    for (int n = 0; n < 600 && !holds(); ++n) receive_for(std::chrono::milliseconds(50));
    return holds();
  }
  bool is_whole() const { return store.has_begun() && std::isinf(store.known_radius(Vec3::Zero())); }

  SteadyClock clock;
  PatchSender sender;
  PatchStore store;
  std::vector<ObjectMove> moves;
  MoveTable confirmed_moves;  // those that the hub confirms with its status
  std::uint32_t request = 9;
  bool knows_effects = true;
  Vec3 p_WD = Vec3::Zero();
  std::array<float, 12> X_WS = kIdentityPose;
  std::uint64_t sample = 0;
  int received_count = 0;
};

}  // namespace hapton
