#include "devices/vendor_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "devices/hd_library.h"
#include "tests/standins/paths.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using standin::library;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(VendorLibrary, IsLoadedAndItsFunctionsAreFound) {
  const auto loaded = VendorLibrary::open(kOpenHaptics, library("openhaptics/libHD.so"));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(loaded->file(), library("openhaptics/libHD.so"));
  EXPECT_NE(loaded->find<unsigned()>("hdCheckCalibration"), nullptr);
  EXPECT_EQ(loaded->find<unsigned()>("hdNoSuchThing"), nullptr);
}

TEST(VendorLibrary, ThatIsMissingIsReportedWithTheLoadersTextForEveryName) {
  constexpr std::array<std::string_view, 2> kFiles = {"libhapton-no-such.so", "libhapton-no-such.so.3"};
  const KnownVendorLibrary none = {"No SDK", "none", kFiles, "nothing", "nowhere", {}};
  const auto loaded = VendorLibrary::open(none);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().what, HasSubstr("libhapton-no-such.so: cannot open shared object file: No such file or directory"));
  EXPECT_THAT(loaded.error().what, HasSubstr("libhapton-no-such.so.3: cannot open shared object file"));
  EXPECT_THAT(loaded.error().what, HasSubstr("LD_LIBRARY_PATH"));
  EXPECT_THAT(loaded.error().what, HasSubstr("nowhere"));
  EXPECT_THAT(loaded.error().what, Not(HasSubstr("\n")));
}

TEST(VendorLibrary, WithAMissingDependencyNamesItAndItsPackage) {
  std::vector<FailedLoad> failures;
  const VendorLibrary loaded = VendorLibrary::try_open(kOpenHaptics, library("needy/libHD.so"), failures);
  EXPECT_THAT(loaded.file(), IsEmpty());
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].error, HasSubstr("libPhantomIOLib42.so: cannot open shared object file"));
  EXPECT_THAT(failures[0].hint, HasSubstr("needs libPhantomIOLib42.so"));
  EXPECT_THAT(failures[0].hint, HasSubstr("Touch device driver"));
}

TEST(VendorLibrary, ThatIsThereButDoesNotLoadGivesTheHintRatherThanThoseThatAreNotThere) {
  const std::string needy = library("needy/libHD.so");
  const std::array<std::string_view, 2> files = {"libhapton-no-such.so", needy};
  const KnownVendorLibrary mixed = {"OpenHaptics", "openhaptics", files, "", "", {}};
  EXPECT_THAT(VendorLibrary::open(mixed).error().what, HasSubstr("Touch device driver"));
}

TEST(VendorLibrary, ThatIsNoLibrarySaysSo) {
  const ScratchFolder folder;
  const auto file = folder.write("libHD.so", "this is not a library");
  EXPECT_THAT(VendorLibrary::open(kOpenHaptics, file).error().what, HasSubstr("not a library for this machine"));
  EXPECT_THAT(VendorLibrary::open(kOpenHaptics, (folder.path() / "none.so").string()).error().what, HasSubstr("there is no such file"));
}

TEST(VendorLibrary, WithoutAFunctionThatIsNeededSaysWhich) {
  const auto loaded = hd::load(library("old/libHD.so"));
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().what, HasSubstr("old/libHD.so has no hdGetError;"));
}

TEST(VendorLibrary, HintsFitWhatLoadersSay) {
  const auto hint = [](std::string_view error) { return hint_for_load_error("libHD.so", error); };
  EXPECT_THAT(hint("libncurses.so.5: cannot open shared object file: No such file or directory"), HasSubstr("libncurses5"));
  EXPECT_THAT(hint("libwhat.so.1: cannot open shared object file: No such file or directory"), HasSubstr("needs libwhat.so.1"));
  EXPECT_THAT(hint("libHD.so: wrong ELF class: ELFCLASS32"), HasSubstr("64-bit"));
  EXPECT_THAT(hint("/usr/lib/libHD.so: undefined symbol: _ZN3foo"), HasSubstr("different releases"));
  EXPECT_THAT(hint("/lib/libc.so.6: version `GLIBC_2.99' not found (required by libHD.so)"), HasSubstr("newer"));
  EXPECT_THAT(hint("libHD.so: file too short"), HasSubstr("64-bit"));
  EXPECT_THAT(hint("libHD.so: cannot enable executable stack as shared object requires: Invalid argument"), HasSubstr("execstack -c"));
  EXPECT_THAT(hint("libHD.so: cannot open shared object file: Permission denied"), HasSubstr("chmod a+r"));
  EXPECT_THAT(hint("something new"), HasSubstr("ldd"));
}

TEST(VendorLibrary, EveryKnownOneHasNamesAndASource) {
  for (const KnownVendorLibrary& known : known_vendor_libraries()) {
    EXPECT_FALSE(known.file_names.empty());
    for (const std::string_view text : {known.name, known.device, known.devices, known.source}) EXPECT_FALSE(text.empty());
  }
}

}  // namespace
}  // namespace hapton
