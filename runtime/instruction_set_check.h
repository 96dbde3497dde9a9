#pragma once

namespace hapton {

// The CPU features that a program may need and that some x86 CPUs lack.
struct CpuNeeds {
  bool avx2 = false;
  bool fma = false;
  bool bmi2 = false;
  bool avx512 = false;
};

// The features that the including file was compiled for (-march).
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

// The features that this CPU has.
CpuNeeds read_cpu();

// The name of the first needed feature that is not available; nullptr: none is missing.
const char* find_missing(CpuNeeds needed, CpuNeeds available);

// Called at the beginning of every main: if this CPU lacks an instruction set that the program was built for, prints one line and exits
// with 1. Otherwise the program would crash later at an illegal instruction. The check itself uses none of those instructions.
void exit_unless_cpu_has(CpuNeeds needs, const char* program);

inline void check_cpu(const char* program) { exit_unless_cpu_has(compiled_cpu_needs(), program); }

}  // namespace hapton
