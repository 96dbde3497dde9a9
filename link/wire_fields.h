#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "core/math/types.h"
#include "link/codec.h"
#include "link/wire_text.h"

// Fields that several messages of proto/hapton.proto have. Field: a repeated field with room for what is written, so that writing uses no
// heap. A read function returns false for a value that the contract rules out. RT: yes.
namespace hapton {

// Whether this is a valid magnitude, rate or duration. False for NaN as well.
inline bool is_amount(double value) { return value >= 0.0 && value <= kMaxWireMagnitude; }

inline bool is_wire_time(std::int64_t time_ns) { return time_ns >= -kMaxWireTimeNs && time_ns <= kMaxWireTimeNs; }

// Whether this is a valid servo rate; 0: unknown, or not to be changed. False for NaN as well.
inline bool is_servo_rate(double rate_hz) { return rate_hz == 0.0 || (rate_hz >= kMinServoRateHz && rate_hz <= kMaxServoRateHz); }

// Reads the number of an object in the scene, from 0.
inline bool read_object_number(std::uint32_t from, std::int32_t& to) {
  to = static_cast<std::int32_t>(from);
  return from <= static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
}

// On the wire 0 means no object, so that a sender that does not know the field says the same. A number too large is read as none, too.
inline std::uint32_t write_object(std::int32_t object) { return object < 0 ? 0U : static_cast<std::uint32_t>(object) + 1U; }
inline std::int32_t read_object(std::uint32_t touched) {
  return touched > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max()) ? -1 : static_cast<std::int32_t>(touched) - 1;
}

inline bool is_wire_vector(const Vec3& v) { return v.allFinite() && v.cwiseAbs().maxCoeff() <= kMaxWireMagnitude; }

constexpr double kUnitTolerance = 1e-3;  // as proto/hapton.proto states
// False for NaN as well.
inline bool is_wire_rotation(const Quat& q) { return std::abs(q.norm() - 1.0) <= kUnitTolerance; }

template <class Field>
void write_vector(Field& field, const Vec3& v) {
  field.Clear();
  for (int i = 0; i < 3; ++i) {
    field.AddAlreadyReserved(v[i]);
  }
}

template <class Field>
bool read_vector(const Field& field, Vec3& v) {
  if (field.size() != 3) {
    return false;
  }
  v = Vec3(field.Get(0), field.Get(1), field.Get(2));
  return is_wire_vector(v);
}

// Reads zero if the field is absent, as it is in the messages of a program that does not know it.
template <class Field>
bool read_optional_vector(const Field& field, Vec3& v) {
  v = Vec3::Zero();
  return field.empty() || read_vector(field, v);
}

template <class Field>
void write_rotation(Field& field, const Quat& q) {
  field.Clear();
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) {
    field.AddAlreadyReserved(value);
  }
}

template <class Field>
bool read_rotation(const Field& field, Quat& q) {
  if (field.size() != 4) {
    return false;
  }
  q = Quat(field.Get(0), field.Get(1), field.Get(2), field.Get(3));
  return is_wire_rotation(q);
}

template <class Numbers, class Field>
void add_numbers(const Numbers& from, Field& field) {
  for (const auto value : from) field.AddAlreadyReserved(value);
}

template <class Numbers, class Field>
void write_numbers(const Numbers& from, Field& field) {
  field.Clear();
  add_numbers(from, field);
}

template <std::size_t N>
void write_text(const std::array<char, N>& from, std::string& to) {
  to.assign(text_of(from));
}

// The last byte stays NUL.
template <std::size_t N>
bool read_text(const std::string& from, std::array<char, N>& to) {
  if (from.size() >= N ||
      std::any_of(from.begin(), from.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; })) {
    return false;
  }
  to = {};
  std::copy(from.begin(), from.end(), to.begin());
  return true;
}

}  // namespace hapton
