#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/force/force_method.h"
#include "core/force/streamed_method.h"
#include "core/force/touch_step.h"
#include "link/commanded_move.h"
#include "link/shape_parts.h"
#include "patch/patch_chain.h"
#include "patch/patch_maker.h"
#include "patch/patch_source.h"
#include "patch/patch_store.h"
#include "patch/tile_partition.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_scene.h"

namespace hapton {

// The scene on the grid that its tiles have, and in the local frame of its patches: the same surface, touched whole.
inline TouchScene on_patch_grid(TouchScene scene) {
  const PatchGrid grid = make_tiles(scene).grid;
  for (TouchObject& object : scene.objects) {
    TriangleMesh mesh = *object.mesh;
    for (Vec3& vertex : mesh.vertices) vertex = grid.at(grid.round(vertex));
    object.mesh = made::shared(std::move(mesh));
  }
  scene.part_of = grid.box();
  return scene;
}

// All parts of a scene that moves, as messages: in order, as an ideal link brings them.
inline std::vector<Message> parts_of(const TiledScene& tiled, std::uint32_t epoch = 1) {
  std::vector<Message> parts;
  PatchSource source(tiled, 0.0, 7, epoch, {.bits_per_s = 1e15, .least_reach_m = 1e3});
  PatchStore store;  // what it has is not sent again
  std::int64_t last_ns = 1'000'000'000;
  for (std::int64_t now_ns = last_ns; now_ns - last_ns < 50'000'000; now_ns += 1'000'000) {
    while (auto part = source.take(now_ns)) {
      (void)store.accept_part(*part);
      parts.push_back(std::move(*part));
      last_ns = now_ns;
    }
    source.accept(store.status());
  }
  return parts;
}

// The body is whole once all parts are there, whatever kind comes last; and again in the next epoch.
template <class... Last>
void expect_known_whichever_is_last(const TiledScene& tiled, std::uint32_t body) {
  PatchStore store;
  std::uint32_t epoch = 0;
  const auto expect_known_with_last = [&](auto&& is_last) {
    std::vector<Message> parts = parts_of(tiled, ++epoch);
    std::stable_partition(parts.begin(), parts.end(), [&](const Message& part) { return !is_last(part); });
    for (const Message& part : parts) (void)store.accept_part(part);
    EXPECT_TRUE(store.make_piece(Vec3::Zero(), 1.0, 1, body).scene.has_deformation()) << epoch;
  };
  (expect_known_with_last([](const Message& part) { return std::holds_alternative<Last>(part); }), ...);
}

// A scene that moves, touched whole and by patches of its bodies, on an ideal link: the same samples, the same scene time.
class ChainStage {
 public:
  static constexpr double kStepS = 1e-3;

  // few: triangles of a patch. Pre: the scene is on the grid.
  explicit ChainStage(const TouchScene& scene, std::size_t few = PatchMaker::kFewTriangles) {
    whole_ = std::make_unique<TouchStep>(*make_method({}, scene), scene);
    const TiledScene tiled = make_tiles(scene);
    for (const Message& part : parts_of(tiled)) (void)store_.accept_part(part);
    for (std::uint32_t body = 0; body < tiled.bodies.size(); ++body) makers_.emplace_back(few, body);
    (void)chain_.take(store_.make_bodies(0));
  }

  struct Felt {
    std::optional<PatchOutput> patch;
    TouchOutput whole;
  };

  // may_make: patches that are due.
  Felt step(const Vec3& p_WD, const Pose& X_WS = Pose::Identity(), bool may_make = true) {
    time_s_ += kStepS;
    const TouchInput input{.p_WD = p_WD, .X_WS = X_WS, .dt_s = kStepS, .time_s = time_s_};
    if (is_first_) whole_->reset(input);
    // Before the first step there is no hand: patches that are there then are made where it will be.
    TouchInput before = input;
    before.dt_s = before_s_;
    if (std::exchange(is_first_, false)) (void)chain_.step(before);
    if (may_make) make_patches();
    return {chain_.step(input), whole_->step(input)};
  }

  // The haptics node decides it; the hub knows of it when it gets it.
  bool decide(const ObjectMove& move) { return whole_->command(move.object, to_command(move)); }
  void announce(const ObjectMove& move) {
    (void)moves_.take(move);
    chain_.note_moves(moves_);
  }
  // The same for a shape of an object that programs deform: the displacement of each vertex, m. Returns whether the surface takes it.
  using Shape = std::vector<ShapePart::Displacement>;
  bool deform(const ShapeStart& start, const Shape& shape) {
    StreamedMethod& method = *whole_->find_streamed(start.object);
    std::vector<Vec3> to(method.stager().rest().begin(), method.stager().rest().end());
    for (std::size_t v = 0; v < to.size(); ++v) to[v] += Vec3(shape[v][0], shape[v][1], shape[v][2]);
    auto stage = method.stager().make(method.newest_stage().to, to);
    if (!stage) return false;
    (void)method.offer_at(std::move(*stage), 1e-9 * static_cast<double>(start.start_ns),
                          1e-9 * static_cast<double>(start.end_ns - start.start_ns));
    return true;
  }
  void announce(const ShapeStart& start, const Shape& shape) {
    for (std::uint32_t first = 0; first < shape.size(); first += ShapePart::kMaxHere) {
      const ObjectShape part{.source = start.source, .serial = start.serial, .object = start.object, .part = make_shape_part(shape, first)};
      (void)store_.accept_shape(part, Arrival::newest);
    }
    (void)store_.accept_shape(start, Arrival::newest);
  }
  const CommandedMotion* find_commanded(int object) const { return whole_->find_commanded(object); }

  double time_s() const { return time_s_; }
  // Both before the first step. The chain's time begins with it, as that of the whole scene does: almost none has passed before.
  void begin_together() { before_s_ = 1e-12; }
  void skip_to(double time_s) { time_s_ = time_s; }
  PatchChain& chain() { return chain_; }
  TouchStep& whole() { return *whole_; }
  PatchStore& store() { return store_; }

 private:
  void make_patches() {
    const auto time_ns = static_cast<std::int64_t>(1e9 * time_s_);
    for (std::size_t link = 0; link < makers_.size(); ++link) {
      (void)chain_.take_retired(link);
      makers_[link].note_hand(chain_.hand_of(link, time_ns, time_ns));
      make_stages(link);
      auto patch = makers_[link].make_if_due(store_, 0);
      if (patch == nullptr) continue;
      makers_[link].note_made(1.0);  // it takes so long that the next one has to be small
      (void)chain_.offer(link, std::move(patch));
      make_stages(link);
    }
  }

  // As LocalPatch and PatchThread exchange them: one waits to be taken.
  void make_stages(std::size_t link) {
    std::unique_ptr<PatchShape>& stage = stages_[link];
    for (bool is_taken = true; is_taken;) {
      if (stage == nullptr) stage = makers_[link].make_stage_if_due(store_);
      is_taken = stage != nullptr && chain_.take(link, *stage);
      if (is_taken) stage.reset();
    }
  }

  std::unique_ptr<TouchStep> whole_;
  PatchStore store_;
  std::vector<PatchMaker> makers_;                                      // of the bodies
  std::array<std::unique_ptr<PatchShape>, PatchChain::kLinks> stages_;  // on their way to the chain
  PatchChain chain_;
  MoveTable moves_;
  double time_s_ = 0.0;
  bool is_first_ = true;
  double before_s_ = kStepS;
};

}  // namespace hapton
