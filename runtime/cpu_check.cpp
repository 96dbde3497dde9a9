#include "runtime/cpu_check.h"

#include <cstdio>
#include <cstdlib>

namespace hapton {

void exit_unless_cpu_has(CpuNeeds needs, const char* program) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const char* missing = nullptr;
  if (needs.avx2 && !__builtin_cpu_supports("avx2")) missing = "AVX2";
  if (needs.fma && !__builtin_cpu_supports("fma")) missing = "FMA";
  if (needs.bmi2 && !__builtin_cpu_supports("bmi2")) missing = "BMI2";
  if (needs.avx512 && !__builtin_cpu_supports("avx512f")) missing = "AVX-512";
  if (missing != nullptr) {
    std::fprintf(stderr, "%s: this CPU has no %s, which this build needs; build with -DHAPTON_MARCH= for a plain x86-64 program\n",
                 program, missing);
    std::exit(1);
  }
#else
  (void)needs;
  (void)program;
#endif
}

}  // namespace hapton
