#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/effects/space_effect.h"
#include "core/effects/surface_effects.h"

// The numbers that define each effect, in the order in which they cross the network. One function for each effect serves both ways:
// NumberWriter appends the numbers, NumberReader takes them and checks their range. Each function names all members of its effect, so that
// it does not compile when the effect gets one more.
namespace hapton {

class NumberWriter {
 public:
  void finite(double number) { numbers_.push_back(number); }
  void amount(double number) { numbers_.push_back(number); }
  void positive(double number) { numbers_.push_back(number); }
  void force(double force_n) { numbers_.push_back(force_n); }
  void force_or_none(double force_n) { numbers_.push_back(force_n); }
  void point(const Vec3& p) {
    for (int k = 0; k < 3; ++k) numbers_.push_back(p[k]);
  }
  void force(const Vec3& force_n) { point(force_n); }
  void direction(const Vec3& unit) { point(unit); }
  void volume(const EffectVolume& volume) {
    volume.for_each_number([this](double number) { numbers_.push_back(number); });
  }
  template <class Choice>
  void choice(Choice chosen, Choice) {
    numbers_.push_back(static_cast<double>(chosen));
  }
  std::vector<double> take() { return std::move(numbers_); }

 private:
  std::vector<double> numbers_;
};

// A number that is out of range or missing makes the reader fail for good; from then on what it should read keeps its value.
class NumberReader {
 public:
  explicit NumberReader(std::span<const double> numbers) : numbers_(numbers) {}

  // True if all numbers were read, and each is in its range.
  bool is_done() const { return is_good_ && at_ == numbers_.size(); }

  void finite(double& number) { take(number, -kMax, kMax); }
  void amount(double& number) { take(number, 0.0, kMax); }
  void positive(double& number) { take(number, std::numeric_limits<double>::min(), kMax); }
  void force(double& force_n) { take(force_n, 0.0, kMaxEffectForceN); }
  // Infinity means that there is no such force.
  void force_or_none(double& force_n) {
    take(force_n, 0.0, std::numeric_limits<double>::infinity());
    is_good_ = is_good_ && (std::isinf(force_n) || force_n <= kMaxEffectForceN);
  }
  void point(Vec3& p) {
    for (int k = 0; k < 3; ++k) finite(p[k]);
  }
  void force(Vec3& force_n) {
    point(force_n);
    is_good_ = is_good_ && force_n.norm() <= kMaxEffectForceN;
  }
  void direction(Vec3& unit) {
    point(unit);
    is_good_ = is_good_ && std::abs(unit.norm() - 1.0) <= kUnit;
  }
  void volume(EffectVolume& volume) {
    std::array<double, 7> numbers = {};
    for (double& number : numbers) finite(number);
    const auto read = EffectVolume::from_numbers(numbers);
    is_good_ = is_good_ && read;
    if (is_good_) volume = *read;
  }
  template <class Choice>
  void choice(Choice& chosen, Choice last) {
    double number = 0.0;
    take(number, 0.0, static_cast<double>(last));
    is_good_ = is_good_ && number == std::floor(number);
    if (is_good_) chosen = static_cast<Choice>(static_cast<int>(number));
  }

 private:
  static constexpr double kMax = 1e9;    // a choice: squares and products of a few stay finite
  static constexpr double kUnit = 1e-6;  // a choice: far above the rounding of a unit vector

  void take(double& number, double least, double most) {
    is_good_ = is_good_ && at_ < numbers_.size() && numbers_[at_] >= least && numbers_[at_] <= most;
    if (is_good_) number = numbers_[at_++];
  }

  std::span<const double> numbers_;
  std::size_t at_ = 0;
  bool is_good_ = true;
};

template <class Numbers>
void visit_numbers(Numbers& numbers, SpringEffect& effect) {
  auto& [centre, stiffness_n_per_m, max_force_n] = effect;
  numbers.point(centre);
  numbers.amount(stiffness_n_per_m);
  numbers.force(max_force_n);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, ConstantEffect& effect) {
  auto& [force_n, volume] = effect;
  numbers.force(force_n);
  numbers.volume(volume);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, SnapEffect& effect) {
  auto& [target, position, direction, range_m, max_force_n] = effect;
  numbers.choice(target, SnapEffect::Target::plane);
  numbers.point(position);
  numbers.direction(direction);
  numbers.positive(range_m);
  numbers.force(max_force_n);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, GravityWellEffect& effect) {
  auto& [centre, radius_m, max_force_n] = effect;
  numbers.point(centre);
  numbers.positive(radius_m);
  numbers.force(max_force_n);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, ViscousEffect& effect) {
  auto& [damping_ns_per_m, max_force_n, volume] = effect;
  numbers.amount(damping_ns_per_m);
  numbers.force(max_force_n);
  numbers.volume(volume);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, WaveEffect& effect) {
  auto& [waveform, direction, amplitude_n, frequency_hz, volume] = effect;
  numbers.choice(waveform, Waveform::sawtooth);
  numbers.direction(direction);
  numbers.force(amplitude_n);
  numbers.amount(frequency_hz);
  numbers.volume(volume);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, BurstEffect& effect) {
  auto& [direction, amplitude_n, frequency_hz, decay_s, duration_s, volume] = effect;
  numbers.direction(direction);
  numbers.force(amplitude_n);
  numbers.amount(frequency_hz);
  numbers.positive(decay_s);
  numbers.positive(duration_s);
  numbers.volume(volume);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, MassEffect& effect) {
  auto& [mass_kg, filter_s, max_force_n, volume] = effect;
  numbers.amount(mass_kg);
  numbers.positive(filter_s);
  numbers.force(max_force_n);
  numbers.volume(volume);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, TissueLayer& layer) {
  auto& [depth_m, stiffness_n_per_m, pop_force_n, drag_ns_per_m] = layer;
  numbers.amount(depth_m);
  numbers.amount(stiffness_n_per_m);
  numbers.force_or_none(pop_force_n);
  numbers.amount(drag_ns_per_m);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, ProgressiveStiffness& effect) {
  auto& [n_per_m2] = effect;
  numbers.amount(n_per_m2);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, SurfaceBumps& effect) {
  auto& [pattern, height_m, length_m, direction] = effect;
  numbers.choice(pattern, SurfaceBumps::Pattern::grid);
  numbers.amount(height_m);
  numbers.positive(length_m);
  numbers.direction(direction);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, SurfaceViscosity& effect) {
  auto& [damping_ns_per_m] = effect;
  numbers.amount(damping_ns_per_m);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, SurfaceSnap& effect) {
  auto& [stiffness_n_per_m, range_m] = effect;
  numbers.amount(stiffness_n_per_m);
  numbers.amount(range_m);
}

template <class Numbers>
void visit_numbers(Numbers& numbers, TapVibration& effect) {
  auto& [ns_per_m, frequency_hz, decay_s, max_force_n] = effect;
  numbers.amount(ns_per_m);
  numbers.amount(frequency_hz);
  numbers.positive(decay_s);
  numbers.force(max_force_n);
}

// All but layers, images and recorded textures, which EffectWriter writes, and the drag, which belongs to the material.
template <class Numbers>
void visit_numbers(Numbers& numbers, SurfaceEffects& surface) {
  auto& [progressive, layers, bumps, viscosity, snap, tap, maps, texture, drag] = surface;
  visit_numbers(numbers, progressive);
  visit_numbers(numbers, bumps);
  visit_numbers(numbers, viscosity);
  visit_numbers(numbers, snap);
  visit_numbers(numbers, tap);
}

// The numbers of an effect, a layer or a surface.
template <class Effect>
std::vector<double> numbers_of(Effect effect) {
  NumberWriter writer;
  visit_numbers(writer, effect);
  return writer.take();
}

// False: the numbers do not define such an effect, and some of its members may have been read.
template <class Effect>
bool read_numbers(std::span<const double> numbers, Effect& effect) {
  NumberReader reader(numbers);
  visit_numbers(reader, effect);
  return reader.is_done();
}

}  // namespace hapton
