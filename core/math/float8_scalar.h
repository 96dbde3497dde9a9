#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace hapton::scalar {

// The scalar twin of core/math/float8_avx2.h, for processors without AVX2: the same functions lane by lane, with the same result to the
// last bit. core/math/float8.h documents the functions.

namespace detail {

template <class Lanes, class Function>
Lanes map(const Lanes& a, Function&& f) noexcept {
  Lanes result;
  for (std::size_t i = 0; i < a.v.size(); ++i) result.v[i] = f(a.v[i]);
  return result;
}
template <class Lanes, class Function>
Lanes map(const Lanes& a, const Lanes& b, Function&& f) noexcept {
  Lanes result;
  for (std::size_t i = 0; i < a.v.size(); ++i) result.v[i] = f(a.v[i], b.v[i]);
  return result;
}
inline std::uint32_t word(float x) noexcept { return std::bit_cast<std::uint32_t>(x); }
// Not std::signbit: g++ 12 fails on a loop of it (internal compiler error, or a wrong result at -O3).
inline unsigned sign(float x) noexcept { return word(x) >> 31; }
inline unsigned sign(double x) noexcept { return static_cast<unsigned>(std::bit_cast<std::uint64_t>(x) >> 63); }

template <class Lanes>
unsigned sign_bits(const Lanes& a) noexcept {
  unsigned bits = 0;
  for (std::size_t i = 0; i < a.v.size(); ++i) bits |= sign(a.v[i]) << i;
  return bits;
}

inline float number(std::uint32_t x) noexcept { return std::bit_cast<float>(x); }
inline float all_ones(bool is_set) noexcept { return number(is_set ? 0xFFFFFFFFU : 0U); }

}  // namespace detail

struct Float8 {
  Float8() = default;
  Float8(float all) noexcept { v.fill(all); }
  static Float8 load(const float* from) noexcept {
    Float8 a;
    for (std::size_t i = 0; i < 8; ++i) a.v[i] = from[i];
    return a;
  }
  float operator[](int lane) const noexcept { return v[static_cast<std::size_t>(lane)]; }
  void set_lane(int lane, float x) noexcept { v[static_cast<std::size_t>(lane)] = x; }
  std::array<float, 8> v;
};

inline void store(float* into, Float8 a) noexcept {
  for (const float x : a.v) *into++ = x;
}
inline Float8 operator+(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x + y; });
}
inline Float8 operator-(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x - y; });
}
inline Float8 operator*(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x * y; });
}
inline Float8 operator/(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x / y; });
}
inline Float8 operator&(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::number(detail::word(x) & detail::word(y)); });
}
inline Float8 operator|(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::number(detail::word(x) | detail::word(y)); });
}
inline Float8 operator^(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::number(detail::word(x) ^ detail::word(y)); });
}
inline Float8 operator<(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::all_ones(x < y); });
}
inline Float8 operator<=(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::all_ones(x <= y); });
}
inline Float8 operator>(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::all_ones(x > y); });
}
inline Float8 operator>=(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::all_ones(x >= y); });
}
inline Float8 and_not(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return detail::number(~detail::word(x) & detail::word(y)); });
}
inline Float8 min(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float8 max(Float8 a, Float8 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float8 sqrt(Float8 a) noexcept {
  return detail::map(a, [](float x) { return std::sqrt(x); });
}
inline Float8 fma(Float8 a, Float8 b, Float8 c) noexcept {
  Float8 result;
  for (std::size_t i = 0; i < 8; ++i) result.v[i] = std::fma(a.v[i], b.v[i], c.v[i]);
  return result;
}
inline Float8 fms(Float8 a, Float8 b, Float8 c) noexcept {
  Float8 result;
  for (std::size_t i = 0; i < 8; ++i) result.v[i] = std::fma(a.v[i], b.v[i], -c.v[i]);
  return result;
}
inline Float8 select(Float8 mask, Float8 set, Float8 clear) noexcept {
  Float8 result;
  for (std::size_t i = 0; i < 8; ++i) result.v[i] = detail::sign(mask.v[i]) != 0 ? set.v[i] : clear.v[i];
  return result;
}
inline unsigned sign_bits(Float8 a) noexcept { return detail::sign_bits(a); }

struct Uint32x8 {
  Uint32x8() = default;
  explicit Uint32x8(std::uint32_t all) noexcept { v.fill(all); }
  static Uint32x8 load(const std::uint32_t* from) noexcept {
    Uint32x8 a;
    for (std::size_t i = 0; i < 8; ++i) a.v[i] = from[i];
    return a;
  }
  static Uint32x8 load_unaligned(const std::uint32_t* from) noexcept { return load(from); }
  std::array<std::uint32_t, 8> v;
};

inline Uint32x8 operator+(Uint32x8 a, Uint32x8 b) noexcept {
  return detail::map(a, b, [](std::uint32_t x, std::uint32_t y) { return x + y; });
}
inline Uint32x8 operator&(Uint32x8 a, Uint32x8 b) noexcept {
  return detail::map(a, b, [](std::uint32_t x, std::uint32_t y) { return x & y; });
}
inline Uint32x8 operator|(Uint32x8 a, Uint32x8 b) noexcept {
  return detail::map(a, b, [](std::uint32_t x, std::uint32_t y) { return x | y; });
}
inline Uint32x8 operator^(Uint32x8 a, Uint32x8 b) noexcept {
  return detail::map(a, b, [](std::uint32_t x, std::uint32_t y) { return x ^ y; });
}
inline Uint32x8 operator==(Uint32x8 a, Uint32x8 b) noexcept {
  return detail::map(a, b, [](std::uint32_t x, std::uint32_t y) { return x == y ? 0xFFFFFFFFU : 0U; });
}
inline Float8 as_floats(Uint32x8 a) noexcept { return std::bit_cast<Float8>(a); }
inline Uint32x8 as_words(Float8 a) noexcept { return std::bit_cast<Uint32x8>(a); }
inline unsigned sign_bits(Uint32x8 a) noexcept { return detail::sign_bits(as_floats(a)); }
inline std::uint32_t sum(Uint32x8 a) noexcept {
  std::uint32_t total = 0;
  for (const std::uint32_t x : a.v) total += x;
  return total;
}

struct Float4 {
  Float4() = default;
  explicit Float4(float all) noexcept { v.fill(all); }
  Float4(float a, float b, float c, float d) noexcept : v{a, b, c, d} {}
  static Float4 load_unaligned(const float* from) noexcept { return {from[0], from[1], from[2], from[3]}; }
  float operator[](int lane) const noexcept { return v[static_cast<std::size_t>(lane)]; }
  std::array<float, 4> v;
};

inline void store(float* into, Float4 a) noexcept {
  for (const float x : a.v) *into++ = x;
}
inline Float4 operator+(Float4 a, Float4 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x * y; });
}
inline Float4 min(Float4 a, Float4 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) noexcept {
  return detail::map(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline std::uint32_t last_word(Float4 a) noexcept { return detail::word(a.v[3]); }
inline Float4 with_last_word(Float4 a, std::uint32_t word) noexcept { return {a.v[0], a.v[1], a.v[2], detail::number(word)}; }
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) noexcept {
  const Float4 rows[4] = {a, b, c, d};
  Float4* const columns[4] = {&a, &b, &c, &d};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) columns[i]->v[k] = rows[k].v[i];
  }
}

struct Int4 {
  Int4() = default;
  explicit Int4(std::int32_t all) noexcept { v.fill(all); }
  static Int4 truncated(Float4 a) noexcept {
    Int4 result;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool fits = a.v[i] >= -0x1p31F && a.v[i] < 0x1p31F;
      result.v[i] = fits ? static_cast<std::int32_t>(a.v[i]) : std::numeric_limits<std::int32_t>::min();
    }
    return result;
  }
  std::array<std::int32_t, 4> v;
};

inline void store(std::int32_t* into, Int4 a) noexcept {
  for (const std::int32_t x : a.v) *into++ = x;
}
inline Int4 min(Int4 a, Int4 b) noexcept {
  return detail::map(a, b, [](std::int32_t x, std::int32_t y) { return x < y ? x : y; });
}
inline Int4 max(Int4 a, Int4 b) noexcept {
  return detail::map(a, b, [](std::int32_t x, std::int32_t y) { return x > y ? x : y; });
}
inline Int4 operator>(Int4 a, Int4 b) noexcept {
  return detail::map(a, b, [](std::int32_t x, std::int32_t y) { return x > y ? -1 : 0; });
}
inline unsigned sign_bits(Int4 a) noexcept {
  unsigned bits = 0;
  for (std::size_t i = 0; i < 4; ++i) bits |= (a.v[i] < 0 ? 1U : 0U) << i;
  return bits;
}

struct Double4 {
  Double4() = default;
  explicit Double4(double all) noexcept { v.fill(all); }
  static Double4 load(const double* from) noexcept {
    Double4 a;
    for (std::size_t i = 0; i < 4; ++i) a.v[i] = from[i];
    return a;
  }
  static Double4 load_three(const double* from) noexcept {
    Double4 a(0.0);
    for (std::size_t i = 0; i < 3; ++i) a.v[i] = from[i];
    return a;
  }
  std::array<double, 4> v;
};

inline Double4 operator+(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x + y; });
}
inline Double4 operator-(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x - y; });
}
inline Double4 operator*(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x * y; });
}
inline Double4 operator/(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x / y; });
}
inline Double4 operator<(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return std::bit_cast<double>(x < y ? ~std::uint64_t{0} : std::uint64_t{0}); });
}
inline Double4 operator<=(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return std::bit_cast<double>(x <= y ? ~std::uint64_t{0} : std::uint64_t{0}); });
}
inline Double4 min(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x < y ? x : y; });
}
inline Double4 max(Double4 a, Double4 b) noexcept {
  return detail::map(a, b, [](double x, double y) { return x > y ? x : y; });
}
inline Double4 sqrt(Double4 a) noexcept {
  return detail::map(a, [](double x) { return std::sqrt(x); });
}
inline Double4 select(Double4 mask, Double4 set, Double4 clear) noexcept {
  Double4 result;
  for (std::size_t i = 0; i < 4; ++i) result.v[i] = detail::sign(mask.v[i]) != 0 ? set.v[i] : clear.v[i];
  return result;
}
inline void store(double* into, Double4 a) noexcept {
  for (const double x : a.v) *into++ = x;
}
inline void transpose(Double4& a, Double4& b, Double4& c, Double4& d) noexcept {
  const Double4 rows[4] = {a, b, c, d};
  Double4* const columns[4] = {&a, &b, &c, &d};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) columns[i]->v[k] = rows[k].v[i];
  }
}
inline unsigned sign_bits(Double4 a) noexcept { return detail::sign_bits(a); }
inline Float4 rounded(Double4 a) noexcept {
  return {static_cast<float>(a.v[0]), static_cast<float>(a.v[1]), static_cast<float>(a.v[2]), static_cast<float>(a.v[3])};
}

}  // namespace hapton::scalar
