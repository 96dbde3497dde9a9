#include "runtime/instruction_set_check.h"

#include <cstdio>
#include <cstdlib>

namespace hapton {

CpuNeeds read_cpu() {
  CpuNeeds cpu;
#if defined(__x86_64__)
  __builtin_cpu_init();
  cpu.avx2 = static_cast<bool>(__builtin_cpu_supports("avx2"));
  cpu.fma = static_cast<bool>(__builtin_cpu_supports("fma"));
  cpu.bmi2 = static_cast<bool>(__builtin_cpu_supports("bmi2"));
  cpu.avx512 = static_cast<bool>(__builtin_cpu_supports("avx512f"));
#endif
  return cpu;
}

const char* find_missing(CpuNeeds needed, CpuNeeds available) {
  if (needed.avx2 && !available.avx2) return "AVX2";
  if (needed.fma && !available.fma) return "FMA";
  if (needed.bmi2 && !available.bmi2) return "BMI2";
  if (needed.avx512 && !available.avx512) return "AVX-512";
  return nullptr;
}

void exit_unless_cpu_has(CpuNeeds needs, const char* program) {
  if (const char* missing = find_missing(needs, read_cpu())) {
    std::fprintf(stderr, "%s: this CPU has no %s, which this build needs; build with -DHAPTON_MARCH= for a plain x86-64 program\n", program,
                 missing);
    std::exit(1);
  }
}

}  // namespace hapton
