#include "runtime/instruction_set_check.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(CpuCheckTest, NamesWhatIsMissing) {
  const CpuNeeds all{.avx2 = true, .fma = true, .bmi2 = true, .avx512 = true};
  EXPECT_EQ(find_missing(all, all), nullptr);
  EXPECT_EQ(find_missing({}, {}), nullptr);
  EXPECT_STREQ(find_missing({.avx2 = true}, {}), "AVX2");
  EXPECT_STREQ(find_missing({.avx2 = true, .fma = true}, {.avx2 = true}), "FMA");
  EXPECT_STREQ(find_missing({.bmi2 = true}, {.avx2 = true}), "BMI2");
  EXPECT_STREQ(find_missing(all, {.avx2 = true, .fma = true, .bmi2 = true}), "AVX-512");
}

TEST(CpuCheckTest, ThisTestRunsOnWhatItWasBuiltFor) {
  EXPECT_EQ(find_missing(compiled_cpu_needs(), read_cpu()), nullptr);
  check_cpu("instruction_set_check_test");
}

}  // namespace
}  // namespace hapton
