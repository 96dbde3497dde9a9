#pragma once

namespace hapton {

// CPU features that the including file was compiled for (-march), as far as x86 CPUs differ.
struct CpuNeeds {
  bool avx2 = false;
  bool fma = false;
  bool bmi2 = false;
  bool avx512 = false;
};

constexpr CpuNeeds compiled_cpu_needs() {
  CpuNeeds needs;
#ifdef __AVX2__
  needs.avx2 = true;
#endif
#ifdef __FMA__
  needs.fma = true;
#endif
#ifdef __BMI2__
  needs.bmi2 = true;
#endif
#ifdef __AVX512F__
  needs.avx512 = true;
#endif
  return needs;
}

// What this CPU has of them.
CpuNeeds read_cpu();

// The name of the first thing needed that is not there; nullptr when nothing is missing.
const char* find_missing(CpuNeeds needed, CpuNeeds available);

// First line of every main: when this CPU lacks an instruction set the program was built for, prints one line and exits 1, rather than
// die later of an illegal instruction. Runs without those instructions itself.
void exit_unless_cpu_has(CpuNeeds needs, const char* program);

inline void check_cpu(const char* program) { exit_unless_cpu_has(compiled_cpu_needs(), program); }

}  // namespace hapton
