#include "plugin/plugin_file.h"

#include <elf.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

#include "tests/standins/paths.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string plugin(const std::string& name) { return standin::library("plugins/" + name + ".so"); }

// The error if a file is opened as an effect; empty: none.
std::string open_error(const std::string& path) {
  const auto file = PluginFile::open({.file = path});
  if (!file) return file.error().what;
  const auto effect = file->find_effect();
  return effect ? "" : effect.error().what;
}

TEST(PluginFile, AGoodOneIsLoadedAndItsEffectFound) { EXPECT_EQ(open_error(plugin("odd_effect")), ""); }

TEST(PluginFile, EachFaultIsOneLineWithThePathAndARemedy) {
  const ScratchFolder scratch;
  EXPECT_THAT(open_error((scratch.path() / "gone.so").string()), AllOf(HasSubstr("gone.so"), HasSubstr("No such file")));
  EXPECT_THAT(open_error(scratch.path().string()), HasSubstr("it is a folder"));
  EXPECT_THAT(open_error(scratch.write("text.so", "force = 2 N\n").string()), AllOf(HasSubstr("text.so"), HasSubstr("gcc -shared")));
  EXPECT_THAT(open_error(scratch.write("empty.so", "").string()), HasSubstr("is not a shared library"));
  EXPECT_THAT(open_error(plugin("nothing")), HasSubstr("exports no hapton_effect"));
  EXPECT_THAT(open_error(plugin("old_effect")), AllOf(HasSubstr("version 0"), HasSubstr("this release")));
  EXPECT_THAT(open_error(plugin("small_effect")), HasSubstr("8 bytes"));
  EXPECT_THAT(open_error(plugin("stepless_effect")), HasSubstr("has no step"));
  EXPECT_THAT(open_error(plugin("boundless_effect")), HasSubstr("max_force_n is 1000000000"));
  EXPECT_THAT(open_error(plugin("twisting_effect")), HasSubstr("max_torque_nm is 10.5; state the largest torque it gives, 0 to 10 Nm"));
  EXPECT_THAT(open_error(plugin("needy_effect")), AllOf(HasSubstr("nowhere_to_be_found"), HasSubstr("ldd")));
  for (const char* name : {"nothing", "old_effect", "small_effect", "needy_effect"}) {
    EXPECT_EQ(open_error(plugin(name)).find('\n'), std::string::npos) << name;
  }
}

// Takes the header of a good plug-in and changes it.
TEST(PluginFile, AnotherProcessorAndOtherKindsOfElfAreNamed) {
  const ScratchFolder scratch;
  std::string bytes(4096, '\0');
  std::ifstream(plugin("odd_effect"), std::ios::binary).read(bytes.data(), 4096);
  const auto changed = [&](const std::function<void(Elf64_Ehdr&)>& change) {
    Elf64_Ehdr header;
    std::memcpy(&header, bytes.data(), sizeof header);
    change(header);
    std::string other = bytes;
    std::memcpy(other.data(), &header, sizeof header);
    return open_error(scratch.write("other.so", other).string());
  };
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_machine = EM_RISCV; }), AllOf(HasSubstr("another processor"), HasSubstr("243")));
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_ident[EI_CLASS] = ELFCLASS32; }), HasSubstr("32-bit"));
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_ident[EI_DATA] = ELFDATA2MSB; }), HasSubstr("byte order"));
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_type = ET_REL; }), HasSubstr("an object file"));
  EXPECT_THAT(changed([](Elf64_Ehdr&) {}), HasSubstr("cut short")) << "after 4 kB: the loader would die";
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_phoff = ~0ULL - 8; }), HasSubstr("cut short"));
  EXPECT_THAT(changed([](Elf64_Ehdr& h) { h.e_phentsize = 0, h.e_phnum = 0; }), HasSubstr("cut short"))
      << "other program headers than these";
  EXPECT_THAT(open_error(scratch.write("short.so", bytes.substr(0, 20)).string()), HasSubstr("cut short"));
}

TEST(PluginFile, AnEffectIsNoMethodAndNoDeviceAndSaysWhatItIs) {
  const auto file = PluginFile::open({.file = plugin("odd_effect")});
  ASSERT_TRUE(file);
  EXPECT_THAT(file->find_method().error().what, AllOf(HasSubstr("exports no hapton_method"), HasSubstr("--effect FILE")));
  EXPECT_THAT(file->find_device().error().what, HasSubstr("exports no hapton_device"));
}

TEST(PluginFile, TheHashIsOfBytesAndParameters) {
  const auto hash_of = [](const std::string& name, const char* value) {
    return PluginFile::open({.file = plugin(name), .parameters = {{"n", value}}})->hash();
  };
  EXPECT_EQ(hash_of("odd_effect", "1"), hash_of("odd_effect", "1"));
  EXPECT_NE(hash_of("odd_effect", "1"), hash_of("odd_effect", "2"));
  EXPECT_NE(hash_of("odd_effect", "1"), hash_of("small_effect", "1"));
}

// Otherwise its hash would be that of the new file, and its code that of the old one.
TEST(PluginFile, OneThatWasCompiledAgainSinceItWasLoadedIsRejected) {
  const ScratchFolder scratch;
  const std::filesystem::path mine = scratch.path() / "mine.so";
  const auto compile = [&](const char* name) {
    std::filesystem::remove(mine);  // as a linker does; the loaded file stays as it is
    std::filesystem::copy_file(plugin(name), mine);
  };
  compile("odd_effect");
  EXPECT_EQ(open_error(mine.string()), "");
  compile("nothing");
  EXPECT_THAT(open_error(mine.string()),
              AllOf(HasSubstr("mine.so: has changed since it was loaded"), HasSubstr("start this program again")));
  compile("odd_effect");
  EXPECT_EQ(open_error(mine.string()), "") << "the same bytes";
}

TEST(PluginFile, ARelativePathIsTheCallersFolder) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(plugin("odd_effect")).parent_path());
  EXPECT_EQ(open_error("odd_effect.so"), "") << "the loader alone would look in its own folders";
  std::filesystem::current_path(before);
}

TEST(PluginFile, NamesAreCleanAndShort) {
  EXPECT_EQ(clean_plugin_name("odd one"), "odd_one");
  EXPECT_EQ(clean_plugin_name(nullptr), "unnamed");
  EXPECT_EQ(clean_plugin_name(""), "unnamed");
  EXPECT_EQ(clean_plugin_name("a\n@b,!"), "a__b__");
  EXPECT_EQ(clean_plugin_name(std::string(400, 'x').c_str()).size(), 24U);
}

}  // namespace
}  // namespace hapton
