#include "runtime/instruction_set_check.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

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

TEST(CpuCheckTest, NeedsEachOfThemAlone) {
  EXPECT_EQ(find_missing({}, {.avx2 = true, .fma = true, .bmi2 = true, .avx512 = true}), nullptr);
  EXPECT_STREQ(find_missing({.fma = true}, {.avx2 = true, .bmi2 = true, .avx512 = true}), "FMA");
  EXPECT_STREQ(find_missing({.bmi2 = true}, {.avx2 = true, .fma = true, .avx512 = true}), "BMI2");
  EXPECT_STREQ(find_missing({.avx512 = true}, {}), "AVX-512");
}

#if defined(__x86_64__)
// Compares with the flags that the kernel lists.
TEST(CpuCheckTest, KnowsWhatThisCpuHas) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line) && !line.starts_with("flags")) {
  }
  if (!line.starts_with("flags")) GTEST_SKIP() << "the kernel does not list the CPU's flags";
  std::istringstream words(line);
  const std::set<std::string> flags(std::istream_iterator<std::string>(words), {});
  const CpuNeeds cpu = read_cpu();
  EXPECT_EQ(cpu.avx2, flags.contains("avx2"));
  EXPECT_EQ(cpu.fma, flags.contains("fma"));
  EXPECT_EQ(cpu.bmi2, flags.contains("bmi2"));
  EXPECT_EQ(cpu.avx512, flags.contains("avx512f"));
}
#endif

TEST(CpuCheckTest, ThisTestRunsOnWhatItWasBuiltFor) {
  EXPECT_EQ(find_missing(compiled_cpu_needs(), read_cpu()), nullptr);
  check_cpu("instruction_set_check_test");
}

}  // namespace
}  // namespace hapton
