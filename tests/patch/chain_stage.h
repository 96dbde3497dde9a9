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

// Rounds the scene to the grid of its tiles, with the local unit of its patches: touched as a whole, it has exactly their surface.
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

// All parts of a scene that moves, as messages in the order in which an ideal link delivers them.
inline std::vector<Message> parts_of(const TiledScene& tiled, std::uint32_t epoch = 1) {
  std::vector<Message> parts;
  // Everything is in reach, and no bandwidth limits it.
  PatchSource source(tiled, 0.0, 7, epoch, {.bits_per_s = 1e15, .least_reach_m = 1e3});
  PatchStore store;  // confirms parts, which are then not sent again
  std::int64_t last_ns = 1'000'000'000;
  // Until no part has come for 50 ms.
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

// Expects that the body is complete once all parts are there, whichever kind of part comes last; each kind is tried in its own epoch.
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

// A scene that moves, touched as a whole and by patches of its bodies over an ideal link, with the same samples at the same scene time.
class ChainStage {
 public:
  static constexpr double kStepS = 1e-3;

  // few_triangles: as in PatchMaker. Pre: the scene is on the grid.
  explicit ChainStage(const TouchScene& scene, std::size_t few_triangles = PatchMaker::kFewTriangles) {
    whole_ = std::make_unique<TouchStep>(*make_method({}, scene), scene);
    const TiledScene tiled = make_tiles(scene);
    for (const Message& part : parts_of(tiled)) (void)store_.accept_part(part);
    for (std::uint32_t body = 0; body < tiled.bodies.size(); ++body) makers_.emplace_back(few_triangles, body);
    (void)chain_.take(store_.make_bodies(0));
  }

  struct Outputs {
    std::optional<PatchOutput> patch;
    TouchOutput whole;
  };

  // makes_patches: the patches that are due are made first.
  Outputs step(const Vec3& p_WD, const Pose& X_WS = Pose::Identity(), bool makes_patches = true) {
    time_s_ += kStepS;
    const TouchInput input{.p_WD = p_WD, .X_WS = X_WS, .dt_s = kStepS, .time_s = time_s_};
    if (is_first_) whole_->reset(input);
    // Patches need a hand, and before the first step there is none: the first patches are made where the hand will be.
    TouchInput lead_in = input;
    lead_in.dt_s = lead_in_dt_s_;
    if (std::exchange(is_first_, false)) (void)chain_.step(lead_in);
    if (makes_patches) make_patches();
    return {chain_.step(input), whole_->step(input)};
  }

  // decide: the haptics node decides the move, which the whole scene makes. announce: the hub gets it, and so do the patches.
  bool decide(const ObjectMove& move) { return whole_->command(move.object, to_command(move)); }
  void announce(const ObjectMove& move) {
    (void)moves_.take(move);
    chain_.note_moves(moves_);
  }
  // The same for a shape of an object that programs deform: the displacement of each vertex, m. False: the surface does not take the shape.
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
    for (std::uint32_t first = 0; first < shape.size(); first += ShapePart::kVerticesPerPart) {
      const ObjectShape part{.source = start.source, .serial = start.serial, .object = start.object, .part = make_shape_part(shape, first)};
      (void)store_.accept_shape(part, Arrival::newest);
    }
    (void)store_.accept_shape(start, Arrival::newest);
  }
  const CommandedMotion* find_commanded(int object) const { return whole_->find_commanded(object); }

  double time_s() const { return time_s_; }
  // Call both before the first step. begin_together: the chain's scene time begins with that step, as the whole scene's does.
  void begin_together() { lead_in_dt_s_ = 1e-12; }
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
      makers_[link].note_made(1.0);  // so long that the next one has to be small
      (void)chain_.offer(link, std::move(patch));
      make_stages(link);
    }
  }

  // Passes stages on as PatchThread and LocalPatch do: one at a time waits until the chain takes it.
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
  std::vector<PatchMaker> makers_;                                      // one for each body
  std::array<std::unique_ptr<PatchShape>, PatchChain::kLinks> stages_;  // made, but not yet taken by the chain
  PatchChain chain_;
  MoveTable moves_;
  double time_s_ = 0.0;
  bool is_first_ = true;
  double lead_in_dt_s_ = kStepS;
};

}  // namespace hapton
