#include "patch/felt_effects.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/math/rigid_pose.h"

namespace hapton {
namespace {

// For each object, the number of its body's frame; adds each moving body to `bodies` once.
std::vector<int> frames_of(const std::vector<int>& body_of, std::vector<std::size_t>& bodies) {
  std::vector<int> frames;
  for (const int body : body_of) {
    const auto number = static_cast<std::size_t>(body);
    auto known = std::find(bodies.begin(), bodies.end(), number);
    if (body > 0 && known == bodies.end()) known = bodies.insert(known, number);
    frames.push_back(body > 0 ? static_cast<int>(known - bodies.begin()) : EffectStep::kStill);
  }
  return frames;
}

// Surfaces with the same list of triangles share one MappedSurface, because any number of surfaces may name one list.
std::vector<std::unique_ptr<MapFinder>> make_finders(const std::vector<SurfaceEffects>& surfaces) {
  std::vector<std::unique_ptr<MapFinder>> finders;
  std::map<const void*, std::shared_ptr<const MappedSurface>> prepared;
  for (const SurfaceEffects& surface : surfaces) {
    finders.emplace_back();
    if (!surface.maps.is_on()) continue;
    auto& mapped = prepared[surface.maps.triangles.get()];
    if (mapped == nullptr) mapped = std::make_shared<const MappedSurface>(surface.maps.triangles);
    finders.back() = std::make_unique<MapFinder>(surface.maps, mapped);
  }
  return finders;
}

}  // namespace

FeltEffects::FeltEffects(const SceneEffectSet& effects)
    : frame_of_(frames_of(effects.body_of, bodies_)),
      effects_(effects.surfaces, effects.space, frame_of_),
      maps_(make_finders(effects.surfaces)) {
  X_SF_.resize(bodies_.size(), Pose::Identity());
}

int FeltEffects::frame_of(int object) const noexcept {
  const auto number = static_cast<std::size_t>(object);
  return object >= 0 && number < frame_of_.size() ? frame_of_[number] : EffectStep::kStill;
}

MapFinder* FeltEffects::find_maps(int object) const noexcept {
  const auto number = static_cast<std::size_t>(object);
  return object >= 0 && number < maps_.size() ? maps_[number].get() : nullptr;
}

void FeltEffects::continue_hand_motion(const FeltEffects& other) noexcept {
  if (!other.has_last_input_) return;
  effects_.continue_hand_motion(other.effects_);
  last_input_ = other.last_input_;
  has_last_input_ = true;
}

// A motion of the scene must not count as a motion of the hand.
void FeltEffects::compensate_scene_motion(const TouchInput& input) noexcept {
  if (has_last_input_ && last_input_.X_WS.matrix() != input.X_WS.matrix())
    effects_.note_scene_moved(to_frame(input.X_WS, last_input_.p_WD));
  last_input_ = input;
  has_last_input_ = true;
}

void FeltEffects::add(const TouchInput& input, const BodyPlaces& bodies, std::optional<PatchOutput>& output) noexcept {
  const Vec3 p_SD = to_frame(input.X_WS, input.p_WD);
  if (!p_SD.allFinite()) return;
  compensate_scene_motion(input);
  for (std::size_t f = 0; f < bodies_.size(); ++f) X_SF_[f] = bodies.pose(bodies_[f]);
  effects_.place(X_SF_);
  SurfaceContact contact{.p_SP = p_SD};
  std::optional<SurfacePlace> place;
  std::optional<MapSample> map;
  if (output && output->contact) {
    contact.force_n = input.X_WS.linear().transpose() * output->force_n;
    contact.p_SP += input.X_WS.linear().transpose() * output->visual_offset_m;
    contact.contact = true;
    // Past the edge of a patch the output names no object, unless another body is touched: the object touched last stays.
    if (!output->is_beyond || output->object >= 0) touched_object_ = output->object;
    contact.object = touched_object_;
    const int frame = frame_of(touched_object_);
    const bool moves = frame != EffectStep::kStill;
    if (moves) place = bodies.place(bodies_[static_cast<std::size_t>(frame)], touched_object_);
    if (place) contact.place = &*place;
    if (MapFinder* const finder = find_maps(touched_object_); finder != nullptr) {
      const std::size_t body = moves ? bodies_[static_cast<std::size_t>(frame)] : 0;
      effects_.set_drag(static_cast<std::size_t>(touched_object_), {.stiffness_n_per_m = bodies.stiffness(body, touched_object_)});
      const Vec3 p_OP = moves ? to_frame(X_SF_[static_cast<std::size_t>(frame)], contact.p_SP) : contact.p_SP;
      contact.map = &map.emplace(finder->find(place ? place->p_rest : p_OP));
    }
  } else {
    touched_object_ = -1;
  }
  const EffectResult result = effects_.step(p_SD, input.dt_s, contact, input.buttons);
  if (!output) return;
  output->force_n = result.is_felt ? Vec3(input.X_WS.linear() * result.force_n) : Vec3(Vec3::Zero());
  if (output->contact && result.p_SP != contact.p_SP)
    output->held_offset_m = std::exchange(output->visual_offset_m, input.X_WS.linear() * (result.p_SP - p_SD));
  output->contact = result.is_felt;
}

}  // namespace hapton
