#pragma once

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>

#include <cstdint>

namespace hapton::avx2 {

// The AVX2 and FMA implementation of core/math/float8.h, which documents the functions.

struct Float8 {
  Float8() = default;
  Float8(float all) noexcept : v(_mm256_set1_ps(all)) {}
  explicit Float8(__m256 lanes) noexcept : v(lanes) {}
  static Float8 load(const float* from) noexcept { return Float8(_mm256_load_ps(from)); }
  float operator[](int lane) const noexcept { return v[lane]; }
  void set_lane(int lane, float x) noexcept { v[lane] = x; }
  __m256 v;
};

inline void store(float* into, Float8 a) noexcept { _mm256_store_ps(into, a.v); }
inline Float8 operator+(Float8 a, Float8 b) noexcept { return Float8(_mm256_add_ps(a.v, b.v)); }
inline Float8 operator-(Float8 a, Float8 b) noexcept { return Float8(_mm256_sub_ps(a.v, b.v)); }
inline Float8 operator*(Float8 a, Float8 b) noexcept { return Float8(_mm256_mul_ps(a.v, b.v)); }
inline Float8 operator/(Float8 a, Float8 b) noexcept { return Float8(_mm256_div_ps(a.v, b.v)); }
inline Float8 operator&(Float8 a, Float8 b) noexcept { return Float8(_mm256_and_ps(a.v, b.v)); }
inline Float8 operator|(Float8 a, Float8 b) noexcept { return Float8(_mm256_or_ps(a.v, b.v)); }
inline Float8 operator^(Float8 a, Float8 b) noexcept { return Float8(_mm256_xor_ps(a.v, b.v)); }
inline Float8 operator<(Float8 a, Float8 b) noexcept { return Float8(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)); }
inline Float8 operator<=(Float8 a, Float8 b) noexcept { return Float8(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)); }
inline Float8 operator>(Float8 a, Float8 b) noexcept { return Float8(_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)); }
inline Float8 operator>=(Float8 a, Float8 b) noexcept { return Float8(_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)); }
inline Float8 and_not(Float8 a, Float8 b) noexcept { return Float8(_mm256_andnot_ps(a.v, b.v)); }
inline Float8 min(Float8 a, Float8 b) noexcept { return Float8(_mm256_min_ps(a.v, b.v)); }
inline Float8 max(Float8 a, Float8 b) noexcept { return Float8(_mm256_max_ps(a.v, b.v)); }
inline Float8 sqrt(Float8 a) noexcept { return Float8(_mm256_sqrt_ps(a.v)); }
inline Float8 fma(Float8 a, Float8 b, Float8 c) noexcept { return Float8(_mm256_fmadd_ps(a.v, b.v, c.v)); }
inline Float8 fms(Float8 a, Float8 b, Float8 c) noexcept { return Float8(_mm256_fmsub_ps(a.v, b.v, c.v)); }
inline Float8 select(Float8 mask, Float8 set, Float8 clear) noexcept { return Float8(_mm256_blendv_ps(clear.v, set.v, mask.v)); }
inline unsigned sign_bits(Float8 a) noexcept { return static_cast<unsigned>(_mm256_movemask_ps(a.v)); }

struct Uint32x8 {
  Uint32x8() = default;
  explicit Uint32x8(std::uint32_t all) noexcept : v(_mm256_set1_epi32(static_cast<int>(all))) {}
  explicit Uint32x8(__m256i lanes) noexcept : v(lanes) {}
  static Uint32x8 load(const std::uint32_t* from) noexcept { return Uint32x8(_mm256_load_si256(reinterpret_cast<const __m256i*>(from))); }
  static Uint32x8 load_unaligned(const std::uint32_t* from) noexcept {
    return Uint32x8(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  }
  __m256i v;
};

inline Uint32x8 operator+(Uint32x8 a, Uint32x8 b) noexcept { return Uint32x8(_mm256_add_epi32(a.v, b.v)); }
inline Uint32x8 operator&(Uint32x8 a, Uint32x8 b) noexcept { return Uint32x8(_mm256_and_si256(a.v, b.v)); }
inline Uint32x8 operator|(Uint32x8 a, Uint32x8 b) noexcept { return Uint32x8(_mm256_or_si256(a.v, b.v)); }
inline Uint32x8 operator^(Uint32x8 a, Uint32x8 b) noexcept { return Uint32x8(_mm256_xor_si256(a.v, b.v)); }
inline Uint32x8 operator==(Uint32x8 a, Uint32x8 b) noexcept { return Uint32x8(_mm256_cmpeq_epi32(a.v, b.v)); }
inline Float8 as_floats(Uint32x8 a) noexcept { return Float8(_mm256_castsi256_ps(a.v)); }
inline Uint32x8 as_words(Float8 a) noexcept { return Uint32x8(_mm256_castps_si256(a.v)); }
inline unsigned sign_bits(Uint32x8 a) noexcept { return sign_bits(as_floats(a)); }
inline std::uint32_t sum(Uint32x8 a) noexcept {
  const __m128i halves = _mm_add_epi32(_mm256_castsi256_si128(a.v), _mm256_extracti128_si256(a.v, 1));
  const __m128i pairs = _mm_add_epi32(halves, _mm_shuffle_epi32(halves, 0x4E));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0xB1))));
}

struct Float4 {
  Float4() = default;
  explicit Float4(float all) noexcept : v(_mm_set1_ps(all)) {}
  explicit Float4(__m128 lanes) noexcept : v(lanes) {}
  Float4(float a, float b, float c, float d) noexcept : v(_mm_setr_ps(a, b, c, d)) {}
  static Float4 load_unaligned(const float* from) noexcept { return Float4(_mm_loadu_ps(from)); }
  float operator[](int lane) const noexcept { return v[lane]; }
  __m128 v;
};

inline void store(float* into, Float4 a) noexcept { _mm_store_ps(into, a.v); }
inline Float4 operator+(Float4 a, Float4 b) noexcept { return Float4(_mm_add_ps(a.v, b.v)); }
inline Float4 operator-(Float4 a, Float4 b) noexcept { return Float4(_mm_sub_ps(a.v, b.v)); }
inline Float4 operator*(Float4 a, Float4 b) noexcept { return Float4(_mm_mul_ps(a.v, b.v)); }
inline Float4 min(Float4 a, Float4 b) noexcept { return Float4(_mm_min_ps(a.v, b.v)); }
inline Float4 max(Float4 a, Float4 b) noexcept { return Float4(_mm_max_ps(a.v, b.v)); }
inline std::uint32_t last_word(Float4 a) noexcept { return static_cast<std::uint32_t>(_mm_extract_epi32(_mm_castps_si128(a.v), 3)); }
inline Float4 with_last_word(Float4 a, std::uint32_t word) noexcept {
  return Float4(_mm_castsi128_ps(_mm_insert_epi32(_mm_castps_si128(a.v), static_cast<int>(word), 3)));
}
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) noexcept { _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v); }

struct Int4 {
  Int4() = default;
  explicit Int4(std::int32_t all) noexcept : v(_mm_set1_epi32(all)) {}
  explicit Int4(__m128i lanes) noexcept : v(lanes) {}
  static Int4 truncated(Float4 a) noexcept { return Int4(_mm_cvttps_epi32(a.v)); }
  __m128i v;
};

inline void store(std::int32_t* into, Int4 a) noexcept { _mm_store_si128(reinterpret_cast<__m128i*>(into), a.v); }
inline Int4 min(Int4 a, Int4 b) noexcept { return Int4(_mm_min_epi32(a.v, b.v)); }
inline Int4 max(Int4 a, Int4 b) noexcept { return Int4(_mm_max_epi32(a.v, b.v)); }
inline Int4 operator>(Int4 a, Int4 b) noexcept { return Int4(_mm_cmpgt_epi32(a.v, b.v)); }
inline unsigned sign_bits(Int4 a) noexcept { return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(a.v))); }

struct Double4 {
  Double4() = default;
  explicit Double4(double all) noexcept : v(_mm256_set1_pd(all)) {}
  explicit Double4(__m256d lanes) noexcept : v(lanes) {}
  static Double4 load(const double* from) noexcept { return Double4(_mm256_load_pd(from)); }
  static Double4 load_three(const double* from) noexcept { return Double4(_mm256_maskload_pd(from, _mm256_set_epi64x(0, -1, -1, -1))); }
  __m256d v;
};

inline Double4 operator+(Double4 a, Double4 b) noexcept { return Double4(_mm256_add_pd(a.v, b.v)); }
inline Double4 operator-(Double4 a, Double4 b) noexcept { return Double4(_mm256_sub_pd(a.v, b.v)); }
inline Double4 operator*(Double4 a, Double4 b) noexcept { return Double4(_mm256_mul_pd(a.v, b.v)); }
inline Double4 operator/(Double4 a, Double4 b) noexcept { return Double4(_mm256_div_pd(a.v, b.v)); }
inline Double4 operator<(Double4 a, Double4 b) noexcept { return Double4(_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)); }
inline Double4 operator<=(Double4 a, Double4 b) noexcept { return Double4(_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)); }
inline Double4 min(Double4 a, Double4 b) noexcept { return Double4(_mm256_min_pd(a.v, b.v)); }
inline Double4 max(Double4 a, Double4 b) noexcept { return Double4(_mm256_max_pd(a.v, b.v)); }
inline Double4 sqrt(Double4 a) noexcept { return Double4(_mm256_sqrt_pd(a.v)); }
inline Double4 select(Double4 mask, Double4 set, Double4 clear) noexcept { return Double4(_mm256_blendv_pd(clear.v, set.v, mask.v)); }
inline void store(double* into, Double4 a) noexcept { _mm256_store_pd(into, a.v); }
inline void transpose(Double4& a, Double4& b, Double4& c, Double4& d) noexcept {
  const __m256d low_ab = _mm256_unpacklo_pd(a.v, b.v);
  const __m256d high_ab = _mm256_unpackhi_pd(a.v, b.v);
  const __m256d low_cd = _mm256_unpacklo_pd(c.v, d.v);
  const __m256d high_cd = _mm256_unpackhi_pd(c.v, d.v);
  a.v = _mm256_permute2f128_pd(low_ab, low_cd, 0x20);
  b.v = _mm256_permute2f128_pd(high_ab, high_cd, 0x20);
  c.v = _mm256_permute2f128_pd(low_ab, low_cd, 0x31);
  d.v = _mm256_permute2f128_pd(high_ab, high_cd, 0x31);
}
inline unsigned sign_bits(Double4 a) noexcept { return static_cast<unsigned>(_mm256_movemask_pd(a.v)); }
inline Float4 rounded(Double4 a) noexcept { return Float4(_mm256_cvtpd_ps(a.v)); }

}  // namespace hapton::avx2
#endif
